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

/** Residual from which a loop is strained, standard deviations. */
export const LOOP_STRAINED = 2.0;

/** Residual from which a loop contradicts the rest, standard deviations. */
export const LOOP_CONTRADICTS = 5.0;

/** Scans of a sensor below which the doctor refuses to judge a log. */
export const DOCTOR_LEAST_SCANS = 10;

/** Initial values of the parameters of the sensor model. */
export const SENSOR_MODEL_INITIAL = {
  model: "fixed_increments",
  range_max: 30.0,
  window: 0.0,
  log_odds_hit: 0.85,
  log_odds_miss: -0.4,
  p_free: 0.4,
  p_occ: 0.7,
  sigma: 0.03,
  sigma_growth: 0.01,
  opening: 0.52,
  cone_profile: "flat",
  prior_weight: 2.0,
  no_return: "ignore",
  log_odds_prior: 0.0,
  resolution: 0.05,
} as const;

/** Bounds and steps of their numbers. */
export const SENSOR_MODEL_BOUNDS = {
  range_max: { low: 0.5, high: 100.0, step: 0.1 },
  window: { low: 0.0, high: 2.0, step: 0.05 },
  log_odds_hit: { low: 0.0, high: 3.0, step: 0.05 },
  log_odds_miss: { low: -3.0, high: 0.0, step: 0.05 },
  p_free: { low: 0.01, high: 0.99, step: 0.01 },
  p_occ: { low: 0.01, high: 0.99, step: 0.01 },
  sigma: { low: 0.005, high: 0.5, step: 0.005 },
  sigma_growth: { low: 0.0, high: 0.2, step: 0.005 },
  opening: { low: 0.01, high: 1.57, step: 0.01 },
  prior_weight: { low: 0.1, high: 50.0, step: 0.1 },
  log_odds_prior: { low: -2.0, high: 2.0, step: 0.05 },
  resolution: { low: 0.01, high: 1.0, step: 0.01 },
} as const;
