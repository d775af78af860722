"""The page, part by part: each module draws one, from the session and nothing else."""
