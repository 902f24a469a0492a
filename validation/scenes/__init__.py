"""Scenes that cases are made of: each has a name and says what it shows.

    parts    primitives, materials and a room, of which the others are made
    matrix   every primitive with every material, from outside and inside
    terms    one term of the model a case
    views    cameras, samples, total internal reflection, mirrors of mirrors
    media    media in media, and how they absorb
    spectral light in bands, metals and dispersion
    pictures pictures on surfaces
    chance   scenes drawn from a seed
    stock    what Mitsuba's own plugins can express
    crossed  features that meet in one ray
    found    scenes on which something once failed

What is compared on them, and how closely, is no matter of theirs.
"""
