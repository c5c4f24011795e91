"""Driver of Universal Robots' arms by RTDE, their protocol for real-time data exchange."""
