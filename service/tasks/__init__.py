"""What runs in slots: functions of a JSON payload that may hang or crash on their own."""
