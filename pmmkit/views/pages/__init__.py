"""What the page shows, as plain data: functions from results to what JSON can hold."""
