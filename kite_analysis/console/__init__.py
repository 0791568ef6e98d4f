"""What both command lines share: answers to mistakes, paths of pictures, optional packages."""
