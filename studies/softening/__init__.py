"""Softer grains, faster loading, longer steps: errors against time to solution."""
