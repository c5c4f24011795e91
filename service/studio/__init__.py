"""Studio: scenes in 3-D in a browser; choose a goal, plan, look at the motion, carry it out.

It is a program of its own that asks the server over HTTP like any other client. The page and the
WebSocket behind it are passed on by the server (`front`), which starts the program when the first
browser comes (`process`) and otherwise has nothing to do with it.
"""
