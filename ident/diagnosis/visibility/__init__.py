"""What a recording can show (`ident check`)."""
