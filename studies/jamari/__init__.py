"""The tests and figures of Jamari & Schipper 2006 and 2008."""
