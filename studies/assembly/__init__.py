"""Small-strain stiffness, wave speeds and settlement of packings with rough contacts (see `study`)."""
