"""Trajectories: kinematics of the delta robot, reference paths, limits."""

from trajectories.approach import approach
from trajectories.library import load, names
from trajectories.trajectory import Trajectory

__all__ = ["Trajectory", "approach", "load", "names"]
