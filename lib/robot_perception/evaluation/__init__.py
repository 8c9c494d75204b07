"""How good an estimate is: consistency and error."""
