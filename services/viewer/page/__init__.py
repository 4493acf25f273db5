"""The page in the browser: the picture, the sentence, STOP, and the person's hands."""
