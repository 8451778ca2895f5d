"""Tests, by the rooms of the packages.

Marked `long` and left out by `pytest` alone; `pytest -m long` runs them, and so does `.ci/run`, once:

    algebra/test_condensation.py             older factorizations through whole runs, and without a held direction
    commands/test_fit_command.py             a series of three beams
    commands/test_interrupted.py             further signals from outside, gmsh ended in the middle of its work
    commands/test_show.py                    the law drawn with two widths
    commands/test_streams.py                 five more ways to lose the streams
    cracks/test_band.py                      random walks at two more of Poisson's ratios
    figures/test_cells.py                    many triangles
    figures/test_pictures.py                 five more titles
    fitting/test_fit.py                      intervals from noise and scatter, shared numbers, choice of a curve, points
    growth/test_bodies.py                    a user's mesh, a path that is extruded, two cracks of which one closes
    growth/test_kinked_crack.py              rays in a mesh against linear fracture mechanics; short segments
    growth/test_search.py                    a path repeated, from a face, from a .geo file, on turned meshes, from two notches
    growth/test_settled.py                   finer meshes, segments and steps; a beam with a hole
    measured/test_reading.py                 a million rows
    measured/test_random_tables.py           450 of 500 random tables
    meshing/files/test_random_meshes.py      200 random meshes, 500 damaged ones
    model/test_beams.py                      elements that crack everywhere
    model/test_blocks.py                     bars with bands of a third width and of nine elements
    model/test_condensed_and_rotated.py      beams with and without condensation
    model/test_energies.py                   the balance of the two longest built-in scenes, and of a beam with smaller steps
    model/test_loads.py                      a body that does not bear its weight
    model/test_plane_and_solid.py            the band of a beam in 3D against the plane one
    model/test_planes_on_the_path.py         a kinked path in 3D, elements of second order, four of six paths drawn at random
    model/test_user_meshes.py                a band from a file, solid meshes
    outcome/test_page.py                     a movie
    outcome/test_pickle.py                   comparisons, processes, sizes
    results/test_checkpoints.py              checkpoints at two more rows, in a snap-back, after SIGKILL, with wrong entries
    results/test_inputs.py                   copies that stay, and that do not
    results/test_off_path.py                 the other built-in scenes
    scenes/test_damaged_scenes.py            500 damaged scenes where 100 run by default
    solver/test_newton.py                    the secant tangent of a band
    solver/test_platens.py                   a band under a platen that is free across
    solver/test_snap.py                      snap-backs of a band, with small steps, at more events
    solver/test_stages.py                    separated cracks of five elements, which cut hundreds of steps; a band
    solver/test_stepper.py                   dissipation control of a band
    studies/test_accuracy.py                 default sizes at two more scales, the command
    studies/test_comparison.py               the examples, the command, runs that stop, the band with points off its line
    studies/test_pool.py                     clusters of Dask
    studies/test_run_all.py                  processes
    studies/test_solid_comparison.py         files and profiles in 3D
    studies/test_sweep.py                    processes of a script, runs that fail, pictures
    studies/test_trade.py                    all settings in 2D, those in 3D, processes
    test_examples.py                         those of seconds: found paths, cycles, accuracy, benchmarks, laboratories
    test_own_laws.py                         laws of scripts: both models, saved and resumed, as a command line
    test_examples_of_the_paper.py            Examples 2 to 4 of the paper
    test_extremes.py                         maps of extremes, the corrected contact
    test_random_scenes.py                    57 of the 60 small scenes, two that repeat, most of the twins

Marked `slow` are studies of minutes: `pytest -m slow`.
"""
