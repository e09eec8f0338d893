"""Commands that find poses, and judge them."""
