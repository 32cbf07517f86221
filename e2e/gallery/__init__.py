"""Every state of the page, really reached: a picture of each, and checks that hold in all."""
