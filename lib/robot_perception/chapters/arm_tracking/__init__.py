"""Two arms, one camera: three filters, four cues, and the arms that they hold or lose."""
