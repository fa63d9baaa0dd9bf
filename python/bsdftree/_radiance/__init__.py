"""Radiance's own programs, from the wheel ``pyradiance``: the engine ``radiance``, and what tests and benches share.

In: a scene. Out: a BSDF. Programs are started with lists of arguments, never by a shell.

``programs`` finds and runs them; ``scene`` puts files and what their commands print into one text; ``bins`` says in
which exitant cell a ray counts; ``engine`` traces and counts; ``reduce`` is Radiance's reducer of trees.
"""
