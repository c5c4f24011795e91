"""Linear tool moves (MoveL, LIN): tracing of lines, approaches and retreats of goals."""
