"""Evidence of a change, valid whenever it is looked at: of nights (`change_point`), of blocks (`ranges`)."""
