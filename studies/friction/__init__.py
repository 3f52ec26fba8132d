"""What friction by pressure changes in simple shear, in a bed of ballast and in a slope, beside constant friction."""
