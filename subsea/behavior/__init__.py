"""What a fish wants: intentions and the motor commands that follow."""
