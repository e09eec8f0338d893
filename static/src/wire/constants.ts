// Written by `python -m server.stream.generate` from constants of mapper/: change those.

/** Radius of the simulated robot, which is a disc, metres. */
export const ROBOT_RADIUS = 0.2;

/** Thickness of a wall that is drawn into a world, metres. */
export const WALL_THICKNESS = 0.12;

/** Longest range that a live world's map begins with, metres. */
export const LIVE_RANGE_MAX = 10.0;

/** Window of a hit that a live world's map begins with, metres. */
export const LIVE_WINDOW = 0.2;

/** How far two lattices may lie apart and still be the same, in cells. */
export const LATTICE_TOLERANCE = 0.001;

/** p_occ above which a cell is occupied, as in map_server. */
export const OCCUPIED_THRESHOLD = 0.65;

/** p_occ below which a cell is free, as in map_server. */
export const FREE_THRESHOLD = 0.25;

/** Scans of a sensor below which the doctor refuses to judge a log. */
export const DOCTOR_LEAST_SCANS = 10;
