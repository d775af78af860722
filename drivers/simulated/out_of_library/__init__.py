"""Hidden effects in no library, one file each: a diagnosis can detect them, but not name them."""
