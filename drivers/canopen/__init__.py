"""Drive CiA 402 amplifiers over CANopen."""
