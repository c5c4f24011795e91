"""What executions that run at the same time are watched for."""
