"""The command line: it speaks HTTP like anyone else."""
