"""The convex model of a curve nearby: variables, rows and the program that is solved."""
