"""Goal configurations: inverse kinematics, ranking, tool lines and diagnosis of goal failures."""
