"""Hidden effects that stand in no list, one file each: a diagnosis can find that they are there, not name them."""
