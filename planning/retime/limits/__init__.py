"""Path limits: limits on a motion along a path other than joint limits (tools, zones, torques)."""
