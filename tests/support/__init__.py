"""What tests share: teams, systems, environments and cases. No test file imports another one."""
