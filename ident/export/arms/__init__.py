"""Exports of trees of links, from the parameters that their identified model has in common with real bodies."""
