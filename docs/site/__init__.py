"""What the documentation's site is made of besides its pages: gallery, references, figures."""
