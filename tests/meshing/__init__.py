"""Tests of the package `meshing`."""
