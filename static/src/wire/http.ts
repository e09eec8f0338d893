// Written by `python -m server.http_types` from the routes of the server: change those.

/** An added trajectory, with notes on how it was joined to the scans. */
export interface AddedTrajectory {
  readonly name: string;
  readonly description: string;
  readonly length_m: number;
  readonly source: "log" | "tum" | "slam" | "localized";
  readonly created_s: number | null;
  readonly has_graph: boolean;
  readonly notes: readonly string[];
}

/** p ↦ `scale` · R(theta) · p + (x, y): metres, radians, for points and poses of the estimate. */
export interface Alignment {
  readonly x: number;
  readonly y: number;
  readonly theta: number;
  readonly scale: number;
}

/**
 * The parameters in an AMCL yaml file: the `values` that differ from the defaults. `others` are parameters that do not
 * affect the poses; `notes` concern names that AMCL does not have.
 */
export interface AmclParameters {
  readonly values: Readonly<Record<string, boolean | number | string>>;
  readonly layout: "nav2" | "ros1";
  readonly others: Readonly<Record<string, unknown>>;
  readonly notes: readonly string[];
}

/**
 * The state of an attempt, limited to what the visitor has found. `measures` determine the score of the repair,
 * `repair` is the score of the map checked last, `best` of the best one, and `enough` the score that solves the puzzle,
 * 0 to 1.
 */
export interface Attempt {
  readonly title: string;
  readonly story: string;
  readonly level: number;
  readonly causes: readonly OfferedCause[];
  readonly is_named: boolean;
  readonly wrong: readonly string[];
  readonly hints: readonly string[];
  readonly hints_left: number;
  readonly costs: Costs;
  readonly first: Measures;
  readonly goal: Measures;
  readonly now: Measures | null;
  readonly measures: readonly ("agreement" | "entropy" | "sharpness")[];
  readonly repair: number | null;
  readonly best: number;
  readonly enough: number;
  readonly can_repair: boolean | null;
  readonly repaired_with: RepairedWith | null;
  readonly points: number;
  readonly is_solved: boolean;
  readonly gave_up: boolean;
  readonly answer: SolutionAnswer | null;
}

/** An answer to a puzzle. */
export interface AttemptAnswer {
  /** Name of the cause. */
  readonly cause: string;
}

/**
 * The place of a point of the map's floor in a camera's image. `u` and `v` are fractions of the image's width and
 * height from its upper left corner, 0 for a point outside. `where` is null if the recording lacks necessary data;
 * `why` says which.
 */
export interface CameraAnswer {
  readonly where: "inside" | "outside" | "behind" | null;
  readonly u: number;
  readonly v: number;
  readonly why: string;
}

/** A manual change of a pose graph. Omitted fields change nothing. */
export interface ChangeOfGraph {
  /** Number of a loop to remove. */
  readonly remove?: number | null;
  /** Number of a loop that the robust kernel may not weaken. */
  readonly lock?: number | null;
  /** Number of a loop that it may. */
  readonly unlock?: number | null;
  /** Two scans that are to be joined by a loop. */
  readonly add?: readonly [number, number] | null;
  /** Robust kernel of the loops. */
  readonly robust?: string | null;
  /** Scale of the kernel, standard deviations. */
  readonly robust_scale?: number | null;
  /** Whether the graph is to be as SLAM left it. */
  readonly reset?: boolean;
}

/** The chosen map; null for none. */
export interface ChosenMap {
  readonly map: MapAnswer | null;
}

/** A class that a visitor may join, the number of its members, and the page that it shows. */
export interface ClassAnswer {
  readonly code: string;
  readonly present: number;
  readonly page: string;
}

/** Workers that map logs, and their number of concurrent logs; `error` is why there are none or fewer. */
export interface ClusterState {
  readonly workers: number;
  readonly threads: number;
  readonly error: string;
}

/** The other side, A: a map of the session's log or of another one. */
export interface ComparedMap {
  /** Parameters set for A; all others are the session's. */
  readonly values?: Readonly<Record<string, boolean | number | string>>;
  /** Trajectory of A; by default the log's first. */
  readonly trajectory?: string | null;
  /** Id of another log, as in /api/logs. */
  readonly log?: string | null;
  /** Sensor of that log, if it has several. */
  readonly topic?: string | null;
}

/** Positions of both trajectories in the frame of the reference, metres, and the errors there. */
export interface ComparedPaths {
  readonly reference: readonly (readonly [number, number])[];
  readonly estimate: readonly (readonly [number, number])[];
  readonly errors_m: readonly number[];
}

/** The numbers of a comparison, see :class:`mapper.grid.compare.Comparison`. Pairs are (A, B). */
export interface ComparisonAnswer {
  readonly a: SecondMap | null;
  readonly refused: null;
  readonly cells: number;
  readonly states: readonly (readonly number[])[];
  readonly same: number;
  readonly only: readonly number[];
  readonly both: number;
  readonly entropy_bits: readonly number[];
  readonly contrast: readonly number[];
  readonly mean_difference: number;
  readonly max_difference: number;
  readonly max_at: readonly number[] | null;
}

/** An edge of either kind. `off_m` and `off_deg` are the deviations of the poses from its measurement. */
export interface ConstraintAnswer {
  readonly edge: number;
  readonly scans: readonly [number, number];
  readonly residual: number;
  readonly weight: number;
  readonly locked: boolean;
  readonly kind: "loop" | "odometry";
  readonly off_m: number;
  readonly off_deg: number;
}

/** The contents of the recording; `pictures` are topics with images or clouds, `frames` a number of frames. */
export interface ContentsAnswer {
  readonly topics: readonly TopicAnswer[];
  readonly series: readonly PlottedTopic[];
  readonly frames: number;
  readonly pictures: readonly string[];
  readonly notes: readonly string[];
  readonly state: "ready";
}

/** The contents of the recording are still being read: `progress` from 0 to 1. */
export interface ContentsReading {
  readonly progress: number;
  readonly state: "reading";
}

/** Points deducted for a wrong answer and a hint. */
export interface Costs {
  readonly wrong: number;
  readonly hint: number;
}

/** The diagnosis of a log along a trajectory: findings, causes first, and events by time. */
export interface DoctorAnswer {
  readonly trajectory: string;
  readonly findings: readonly FindingAnswer[];
  readonly events: readonly LogEvent[];
}

/** An edge with both of its scans. `score` and `inliers` are those of the match, 0 to 1; null for an odometry edge. */
export interface EdgeAnswer {
  readonly edge: number;
  readonly scans: readonly [number, number];
  readonly residual: number;
  readonly weight: number;
  readonly locked: boolean;
  readonly kind: "loop" | "odometry";
  readonly off_m: number;
  readonly off_deg: number;
  readonly score: number | null;
  readonly inliers: number | null;
  readonly poses: readonly (readonly [number, number, number])[];
  readonly points: ScanPoints;
}

/** Statistics of the errors of position and heading. */
export interface ErrorFigures {
  readonly translation_m: ErrorStatistics;
  readonly rotation_rad: ErrorStatistics;
}

/**
 * Statistics of n errors, in their unit; `sse`, the sum of squared errors, is in its square. `std` is the standard
 * deviation of the errors around their mean, divided by n, not n − 1.
 */
export interface ErrorStatistics {
  readonly rmse: number;
  readonly mean: number;
  readonly median: number;
  readonly std: number;
  readonly min: number;
  readonly max: number;
  readonly sse: number;
}

/** Errors at some times, seconds since the log's first scan. */
export interface ErrorsOverTime {
  readonly times: readonly number[];
  readonly translation_m: readonly number[];
  readonly rotation_rad: readonly number[];
}

/** Error of a failed job: a stable code and one sentence. */
export interface Failure {
  readonly code: string;
  readonly message: string;
}

/** The numbers of each topic that can be plotted. */
export interface FieldsAnswer {
  readonly topics: readonly TopicFieldsAnswer[];
  readonly state: "ready";
}

/**
 * Uncertainty of a localization in `map` along the log, at some of its `scans`. `deviation_m` is that of the position,
 * `entropy` is in bits, `fit` 0 to 1. `first_converged` is the first of all scans at which the filter had converged.
 */
export interface FilterHistory {
  readonly map: MapAnswer;
  readonly scans: readonly number[];
  readonly seconds: readonly number[];
  readonly entropy: readonly number[];
  readonly deviation_m: readonly number[];
  readonly fit: readonly number[];
  readonly is_converged: readonly boolean[];
  readonly n_particles: readonly number[];
  readonly first_converged: number | null;
}

/**
 * A finding of an examination. `sensor` is empty for a log with one sensor. `possible` marks uncertain findings. `sure`
 * is 0 to 1, `scans` are numbered from 0, `seconds` are their times, `parameters` are values of mapping parameters that
 * would help.
 */
export interface FindingAnswer {
  readonly check: string;
  readonly sentence: string;
  readonly advice: string;
  readonly sure: number;
  readonly scans: readonly number[];
  readonly parameters: Readonly<Record<string, boolean | number | string>> | null;
  readonly sensor: string;
  readonly possible: boolean;
  readonly seconds: readonly number[];
}

/** The facts, the elapsed time in `seconds`, and the number of `runs`. */
export interface FleetFacts {
  readonly scans: number;
  readonly beams: number;
  readonly trajectory: string;
  readonly rows: number;
  readonly cols: number;
  readonly resolution: number;
  readonly contrast: number | null;
  readonly drift_m: number | null;
  readonly findings: readonly FleetFinding[];
  readonly picture: boolean;
  readonly cpu_s: number;
  readonly seconds: number;
  readonly runs: number;
}

/** A finding of the log doctor: its `check`, in a `sentence`; `possible` if there may be another cause. */
export interface FleetFinding {
  readonly check: string;
  readonly sentence: string;
  readonly possible: boolean;
}

/**
 * A log of the fleet; `fraction` is the completed share of its job, `facts` are the results. `options` are those that
 * differ from the defaults, in words. `has_picture` says whether there is a picture of its map, which the reading of a
 * log draws before the fleet does.
 */
export interface FleetLog {
  readonly id: string;
  readonly name: string;
  readonly state: "none" | "queued" | "running" | "done" | "failed";
  readonly has_picture: boolean;
  readonly fraction: number;
  readonly error: Failure | null;
  readonly facts: FleetFacts | null;
  readonly options: string;
}

/** How each log is read and mapped, with the options of `gridbloom fleet`; metres, radians, seconds. */
export interface FleetOptions {
  /** The sensor of each log; null: the one with most scans. */
  readonly topic?: string | null;
  /** The topic of transforms, where there are several. */
  readonly tf?: string | null;
  /** The poses; null: each log’s first. */
  readonly trajectory?: string | null;
  readonly mount_x?: number;
  readonly mount_y?: number;
  readonly mount_yaw?: number;
  readonly mount_upside_down?: boolean;
  readonly time_offset?: number;
}

/** Logs to map. */
export interface FleetRequest {
  /** Map the logs again that failed. */
  readonly again?: boolean;
  /** Map also those again that were mapped, or failed, with other options. */
  readonly options?: FleetOptions | null;
}

/**
 * The numbers of logs by state, and those that have changed since a revision. `whole` says that all are returned: for
 * revision 0, and if a log was removed since. `cluster` is null if processes of this machine do the work; its address
 * is not disclosed.
 */
export interface FleetState {
  readonly revision: number;
  readonly whole: boolean;
  readonly workers: number;
  readonly cluster: ClusterState | null;
  readonly counts: Readonly<Record<"none" | "queued" | "running" | "done" | "failed", number>>;
  readonly logs: readonly FleetLog[];
}

/** The footprint of a robot: its corners in its frame, and both radii of the padded footprint, metres. */
export interface FootprintAnswer {
  readonly footprint: readonly (readonly [number, number])[];
  readonly inscribed_radius: number;
  readonly circumscribed_radius: number;
}

/** The outline of the robot. */
export interface FootprintOfCostmap {
  /** Corners [x, y] in the robot's frame, metres, without padding: 3 to 24, around (0, 0). */
  readonly footprint: readonly (readonly [number, number])[];
}

/**
 * The transforms between two frames; `age_s` is that of the latest at the moment, null before the first. `offset` x, y,
 * z, metres, and `angles` roll, pitch, yaw, radians (REP 103), are the child's pose in the parent at the moment,
 * interpolated between two transforms as in tf2. After the last transform they are the last one's, before the first
 * null. `publishers` are nodes, if the recording names them: a ROS 1 bag, or an MCAP file converted from one. `used` is
 * false for a second parent of the same frame, which is ignored.
 */
export interface FrameEdgeAnswer {
  readonly topic: string;
  readonly parent: string;
  readonly child: string;
  readonly static: boolean;
  readonly count: number;
  readonly rate_hz: number | null;
  readonly age_s: number | null;
  readonly offset: readonly [number, number, number] | null;
  readonly angles: readonly [number, number, number] | null;
  readonly publishers: readonly string[];
  readonly used: boolean;
}

/**
 * The transforms on the topic `tf`, one of `trees`, `at` seconds; `faults` are sentences. `elsewhere` are the frames of
 * the other trees.
 */
export interface FramesAnswer {
  readonly at: number;
  readonly tf: string;
  readonly trees: readonly string[];
  readonly fixed: string;
  readonly sensor: string;
  readonly frames: readonly string[];
  readonly elsewhere: readonly string[];
  readonly edges: readonly FrameEdgeAnswer[];
  readonly faults: readonly string[];
}

/** State of the service. */
export interface Health {
  readonly status: "alive" | "ready";
}

/** The history of a simulation. Its world, seed and history reproduce its recording and its map. */
export interface History {
  /** Initial values of the simulated sensor. */
  readonly sensor?: Readonly<Record<string, boolean | number | string>>;
  /** Initial edits of the world. */
  readonly edits?: WorldEdits;
  /** Physics steps of 0.02 s since the beginning. */
  readonly steps?: number;
  /** Each action with the step before which it was carried out; null if only the pose is known. */
  readonly journal?: readonly (readonly [number, Readonly<Record<string, unknown>>])[] | null;
  /** Final pose of the robot, if journal is null. */
  readonly pose?: readonly [number, number, number] | null;
  /** Whether the robot explores by itself then. */
  readonly auto?: boolean;
  /** Mapping parameters that differ from the initial ones. */
  readonly parameters?: Readonly<Record<string, boolean | number | string>>;
  /** The robot's faults. */
  readonly faults?: Readonly<Record<string, boolean | number | string>>;
  /** Simulated seconds per second. */
  readonly speed?: number | null;
  /** Whether the session plays. */
  readonly playing?: boolean;
  /** The commands that begin the costmap and set the goal of its path. */
  readonly navigation?: readonly (Readonly<Record<string, unknown>>)[];
}

/** A line logged by a node, `seconds` from the log's first scan; `level` as in ROS 2, 10 to 50. */
export interface LineAnswer {
  readonly seconds: number;
  readonly level: number;
  readonly topic: string;
  readonly name: string;
  readonly text: string;
}

/** The lines logged by nodes, ascending in time; `left_out` is the number beyond the limit. */
export interface LinesAnswer {
  readonly lines: readonly LineAnswer[];
  readonly left_out: number;
}

/**
 * A link as seen by its owner: the view that it opens, and the number of visitors `watching`. `count` is the number of
 * scans of the log, `index` the number of scans in the map. `changed` names the parameters that differ from the initial
 * ones.
 */
export interface LinkAnswer {
  readonly token: string;
  readonly address: string;
  readonly created_s: number;
  readonly log: string;
  readonly topic: string | null;
  readonly trajectory: string | null;
  readonly index: number;
  readonly count: number;
  readonly changed: readonly string[];
  readonly watching: number;
}

/** Links to a log, newest first. */
export interface LinkList {
  readonly links: readonly LinkAnswer[];
}

/** `values` that differ from the defaults; `initial_pose` is in the map, x, y (m) and yaw, null: anywhere. */
export interface LocalizationParameters {
  readonly values: Readonly<Record<string, boolean | number | string>>;
  readonly initial_pose: readonly [number, number, number] | null;
}

/** Result of localizing a log: `trajectory` is the name of the new one. */
export interface LocalizationResult {
  readonly map_title: string;
  readonly odometry: string;
  readonly first_converged: number | null;
  readonly converged: number;
  readonly is_converged: boolean;
  readonly updates: number;
  readonly median_fit: number;
  readonly cpu_s: number;
  readonly sure: number;
  readonly is_sure: boolean;
  readonly left_out: number;
  readonly trajectory: string;
}

/** State of the localization of a log: the number of scans with poses, and whether the filter has converged. */
export interface LocalizationStatus {
  readonly state: "none" | "queued" | "running" | "done" | "failed" | "cancelled";
  readonly created_s: number;
  readonly error: Failure | null;
  readonly fraction: number;
  readonly elapsed_s: number | null;
  readonly ahead: number;
  readonly log: string;
  readonly topic: string | null;
  readonly odometry: string | null;
  readonly parameters: LocalizationParameters;
  readonly result: LocalizationResult | null;
  readonly scans: number;
  readonly is_converged: boolean;
  readonly n_particles: number;
}

/**
 * A log in the HTTP interface. Facts are null until the log has been read. `reading_s` are seconds since its reading
 * began, null while it is not being read; `tags` are the visitor's own. `costmaps` is their number in a recording
 * without scans, `clouds` the number of 3D scans in a file without planar ones (an octree counts as one) and `points`
 * the number of their points, or of leaves of the octree. `topics` are the streams of messages in the file, its sensors
 * first.
 */
export interface LogAnswer {
  readonly id: string;
  readonly name: string;
  readonly source: "upload" | "folder" | "sample";
  readonly state: "queued" | "reading" | "ready" | "failed";
  readonly bytes: number;
  readonly progress: number;
  readonly reading_s: number | null;
  readonly error: Failure | null;
  readonly has_picture: boolean;
  readonly tags: readonly string[];
  readonly scans: number | null;
  readonly costmaps: number;
  readonly clouds: number;
  readonly points: number;
  readonly map: MapSummary | null;
  readonly beams: number | null;
  readonly duration_s: number | null;
  readonly format: string | null;
  readonly time: TimeSummary | null;
  readonly mount: readonly [number, number, number] | null;
  readonly upside_down: boolean;
  readonly trajectories: readonly TrajectoryAnswer[];
  readonly topics: readonly Topic[];
  readonly notes: readonly string[];
}

/** An event of a log: the robot was moved without its wheels, its clock was set, or there is a gap in it. */
export interface LogEvent {
  readonly kind: "pushed" | "slipped" | "lifted" | "clock" | "gap";
  /** begin in recorded time, s */
  readonly seconds: number;
  /** end in recorded time, s */
  readonly until_s: number;
  /** begin in recorded time, m:ss.mmm */
  readonly time: string;
  /** begin in UTC, ISO 8601; null where the log's clock does not tell it */
  readonly utc: string | null;
  /** begin on the log's clock, ns */
  readonly stamp_ns: number | null;
  /** last scan before it, from 0 */
  readonly scan: number;
  /** first scan after it */
  readonly until_scan: number;
  /** motion by the scans less that by the wheels: ahead, m */
  readonly ahead_m: number | null;
  /** the same to the left, m */
  readonly left_m: number | null;
  /** the same, counter-clockwise, rad */
  readonly turned_rad: number | null;
  /** length of it, m */
  readonly distance_m: number | null;
  /** side of the robot to which it went */
  readonly direction: "ahead" | "behind" | "left" | "right" | null;
  /** by how much the clock was set, s */
  readonly step_s: number;
  /** how far the robot came in a gap by its poses, m; null where they do not tell */
  readonly moved_m: number | null;
  /** when and what happened, in words */
  readonly sentence: string;
  /** the same without the time, with which the sentence begins */
  readonly what: string;
}

/** The logs on one page of a list, the number of matching logs, and the visitor's tags with numbers of logs. */
export interface LogList {
  readonly logs: readonly LogAnswer[];
  readonly total: number;
  readonly tags: Readonly<Record<string, number>>;
}

/** Part of the map shown in a picture. */
export interface Look {
  /** The place in the middle, metres. */
  readonly x: number;
  /** The place in the middle, metres. */
  readonly y: number;
  /** Metres that one pixel of the page shows. */
  readonly scale: number;
  /** Pixels of the picture. */
  readonly width: number;
  /** Pixels of the picture. */
  readonly height: number;
}

/**
 * A loop of a pose graph: the constraint between two scans of one place, recorded at different times. `residual` is the
 * distance of the graph's solution from the measurement, in standard deviations. `weight` is the factor of the robust
 * kernel, 0 to 1, unless the loop is `locked`.
 */
export interface LoopAnswer {
  readonly edge: number;
  readonly scans: readonly [number, number];
  readonly residual: number;
  readonly weight: number;
  readonly locked: boolean;
}

/** A visitor's puzzle as seen by that visitor. */
export interface MadePuzzleAnswer {
  readonly token: string;
  readonly address: string;
  readonly title: string;
  readonly created_s: number;
  readonly fault: string;
}

/**
 * The progress of a session being created; `what` is null for the request itself. `fraction` is the completed share, 0
 * to 1, null if unknown.
 */
export interface MakingAnswer {
  readonly what: string | null;
  readonly fraction: number | null;
  readonly elapsed_s: number;
}

/**
 * A map in the HTTP interface: `resolution` metres per cell, `origin` x, y (m) and yaw (rad). `classes` are the numbers
 * of terrain patches of a cloud, null for other maps.
 */
export interface MapAnswer {
  readonly title: string;
  readonly rows: number;
  readonly cols: number;
  readonly resolution: number;
  readonly origin: readonly [number, number, number];
  readonly notes: readonly string[];
  readonly classes: TerrainCounts | null;
}

/** The map of the session's log or of another one. */
export interface MapOfLog {
  /** Id of the log, as in /api/logs. */
  readonly log: string;
  /** Sensor of that log, if it has several. */
  readonly topic?: string | null;
  /** Trajectory to map it with; else its first. */
  readonly trajectory?: string | null;
}

/** The size of a map in cells, and the side of a cell in metres. */
export interface MapSummary {
  readonly rows: number;
  readonly cols: number;
  readonly resolution: number;
}

/** Mean errors over `count` relations. */
export interface MeanErrors {
  readonly count: number;
  readonly translation_m: number;
  readonly rotation_deg: number;
}

/**
 * Measures of one map. `agreement` is the F-score of its walls against the reference, 0 to 1 (:func:`wall_agreement`),
 * `sharpness` the contrast of its walls, 0 to 1 (:func:`wall_contrast`), `entropy` the mean entropy of its observed
 * cells, bits.
 */
export interface Measures {
  readonly agreement: number;
  readonly sharpness: number;
  readonly entropy: number;
}

/** Result of a merge: `trajectory` of both logs, and the id and the name of the combined log. */
export interface MergeResult {
  readonly loops: number;
  readonly tried: number;
  readonly score: number;
  readonly cpu_s: number;
  readonly topic: string | null;
  readonly note: string;
  readonly trajectory: string;
  readonly log: string;
  readonly name: string;
}

/** State of a merge of a log with the log `other`. */
export interface MergeStatus {
  readonly state: "none" | "queued" | "running" | "done" | "failed" | "cancelled";
  readonly created_s: number;
  readonly error: Failure | null;
  readonly fraction: number;
  readonly elapsed_s: number | null;
  readonly ahead: number;
  readonly other: string | null;
  readonly result: MergeResult | null;
  readonly stage: string | null;
}

/**
 * A message of a recording: topic, type, size, and the `fields` by name, as in `ros2 topic echo`. `seconds` is its
 * recording time from the log's first scan. `stamp_ns` is the same since 1970, as text, because JSON numbers are not
 * exact enough. Arrays are cut after their first elements, with a text that gives the number of the omitted ones.
 */
export interface MessageAnswer {
  readonly topic: string;
  readonly type: string;
  readonly seconds: number;
  readonly stamp_ns: string;
  readonly bytes: number;
  readonly fields: Readonly<Record<string, unknown>>;
}

/** A cause of a faulty map, and its displayed name. */
export interface NamedCause {
  readonly name: string;
  readonly label: string;
}

/** A link to the current view of a session. */
export interface NewLink {
  /** What part of the map is seen; all of it where this is left out. */
  readonly look?: Look | null;
  /** What else of the page is seen. */
  readonly shown?: Shown | null;
}

/** A localization of a session's log in the chosen map. */
export interface NewLocalization {
  /** Where in the map the robot starts: x, y (m) and yaw (rad); else anywhere. */
  readonly initial_pose?: readonly [number, number, number] | null;
  /** Trajectory that is the odometry; else the log's. */
  readonly odometry?: string | null;
  /** Parameters, as GET /api/localization/parameters names them. */
  readonly parameters?: Readonly<Record<string, boolean | number | string>>;
}

/** A session of a log. */
export interface NewLog {
  readonly kind: "log";
  /** Whether the log plays from the start. */
  readonly playing?: boolean;
  /** A name under which /api/sessions/making/{name} returns the progress until the session is there. */
  readonly name?: string | null;
  /** Whether the log is paused at its end, with the map of all scans. */
  readonly whole?: boolean;
  /** Id of the log, as in /api/logs. */
  readonly log: string;
  /** Sensor of the log, if it has several; ' + ' between several makes one map of them. */
  readonly topic?: string | null;
  /** Trajectory of the log to map with. */
  readonly trajectory?: string | null;
  /** How scans are cut out of clouds and depth images, see /api/parameters; else as by default. */
  readonly cut?: Readonly<Record<string, number>> | null;
}

/** A map to save. */
export interface NewMap {
  /** Name of the new map. */
  readonly name: string;
}

/** A note as written by its author. */
export interface NewNote {
  readonly text: string;
  /** Seconds after the log's first scan. */
  readonly at_s?: number | null;
  /** Number of scans in the map at that time. */
  readonly scan?: number | null;
  /** Place on the map, metres. */
  readonly x?: number | null;
  /** Place on the map, metres. */
  readonly y?: number | null;
  /** Corners of an area on the map, metres; its centroid is the place. */
  readonly outline?: readonly (readonly [number, number])[] | null;
}

/** A puzzle from the current state of a session. */
export interface NewPuzzle {
  /** Fault to add, as in GET; as-it-is: that of the session. */
  readonly fault?: string;
  /** Title; by default that of the world or log. */
  readonly title?: string;
}

/** The sensor of the log to map. */
export interface NewSensor {
  /** Topic of the sensor; ' + ' between several makes one map of them; null: the log's default. */
  readonly topic?: string | null;
  /** How scans are cut out of clouds and depth images, see /api/parameters; else as by default. */
  readonly cut?: Readonly<Record<string, number>> | null;
}

/** A session of a simulation. */
export interface NewSimulation {
  readonly kind: "simulation";
  /** Whether the session plays from the start; false pauses it, also with a story. */
  readonly playing?: boolean;
  /** A name under which /api/sessions/making/{name} returns the progress until the session is there. */
  readonly name?: string | null;
  /** Name of the world; by default the first one. */
  readonly world?: string | null;
  /** The same seed and commands give the same scans. */
  readonly seed?: number | null;
  /** Recorded history of a simulation, from /api/sessions/{id}/story. */
  readonly story?: History | null;
}

/** SLAM of a log. */
export interface NewSlam {
  /** Sensor of the log, if it has several. */
  readonly topic?: string | null;
  /** Trajectory to begin with; where it is left out, the log's odometry. */
  readonly trajectory?: string | null;
  /** Parameters of SLAM, as GET /api/slam/parameters names them. */
  readonly parameters?: Readonly<Record<string, boolean | number | string>>;
  /** How scans are cut out of clouds and depth images, see /api/parameters; else as by default. */
  readonly cut?: Readonly<Record<string, number>> | null;
  /** Parameters of the map that the poses are for, see /api/parameters: SLAM uses its mount and its time offset. */
  readonly mapping?: Readonly<Record<string, boolean | number | string>> | null;
}

/** A session that shows a 3D map of a cloud, a depth folder, an octree, or the clouds of a recording. */
export interface NewVolume {
  readonly kind: "volume";
  /** Whether the session plays from the start. */
  readonly playing?: boolean;
  /** A name under which /api/sessions/making/{name} returns the progress until the session is there. */
  readonly name?: string | null;
  /** Id of the log, as in /api/logs. */
  readonly log: string;
  /** Clouds of a recording that has several. */
  readonly topic?: string | null;
  /** The axis of the file that points up; by default what the poses of depth images say, else z. */
  readonly up?: "z" | "-z" | "y" | "-y" | "x" | "-x" | null;
  /** Id of a log to compare the map with. */
  readonly other?: string | null;
}

/** A note in the HTTP interface, with the fields of its :class:`Pin`; `mine` says whether the visitor wrote it. */
export interface NoteAnswer {
  readonly id: string;
  readonly text: string;
  readonly at_s: number | null;
  readonly scan: number | null;
  readonly x: number | null;
  readonly y: number | null;
  readonly outline: readonly (readonly [number, number])[] | null;
  readonly created_s: number;
  readonly changed_s: number;
  readonly mine: boolean;
}

/** The notes on a log, oldest first. */
export interface NoteList {
  readonly notes: readonly NoteAnswer[];
}

/** A cause to choose; `lesson` is a sentence of the lecture about it, once it was a wrong answer. */
export interface OfferedCause {
  readonly name: string;
  readonly label: string;
  readonly lesson: string | null;
}

/** A puzzle included in the program. */
export interface OfferedPuzzle {
  readonly name: string;
  readonly level: number;
  readonly title: string;
  readonly story: string;
}

/** A class as seen by its lecturer: the addresses of its page, of the counted answers, and of its QR code. */
export interface OpenClassAnswer {
  readonly code: string;
  readonly present: number;
  readonly page: string;
  readonly address: string;
  readonly results: string;
  readonly qr: string;
}

/** The log to merge with. */
export interface OtherLog {
  /** Id of the other log. */
  readonly log: string;
  /** Sensor of it, if it has several. */
  readonly topic?: string | null;
  /** How its scans are cut out of clouds and depth images, see /api/parameters; else as here. */
  readonly cut?: Readonly<Record<string, number>> | null;
  /** Parameters of its map, see /api/parameters: its mount and its time offset are used; else as here. */
  readonly mapping?: Readonly<Record<string, boolean | number | string>> | null;
}

/**
 * One row of a parameter table. `kind` determines which of the other fields are used. `number`: low ≤ value ≤ high in
 * `unit`, with a slider of step `step`. `choice`: one of `choices`. `flag`: a boolean. `group` names the panel that
 * shows the row. `only_for` lists the choices of the table's first row (the model, the sensor's kind) for which the
 * parameter is used; empty means all.
 */
export interface Parameter {
  readonly name: string;
  readonly label: string;
  readonly group: string;
  readonly kind: "number" | "choice" | "flag";
  readonly initial: boolean | number | string;
  readonly sentence: string;
  readonly unit: string;
  readonly low: number;
  readonly high: number;
  readonly step: number;
  readonly choices: readonly string[];
  readonly only_for: readonly string[];
}

/** The rows of a table of parameters. */
export interface ParameterTable {
  readonly table: readonly Parameter[];
}

/** The tables of mapping parameters, of the simulated sensor's, and of the options for cutting scans from clouds. */
export interface ParameterTables {
  readonly parameters: readonly Parameter[];
  readonly sensor: readonly Parameter[];
  readonly cut: readonly Parameter[];
}

/** A topic with numbers for plots. */
export interface PlottedTopic {
  readonly topic: string;
  readonly type: string;
  readonly samples: number;
  readonly plots: readonly string[];
}

/** SLAM of a session's log. */
export interface PoseCorrection {
  /** Parameters of SLAM, as GET /api/slam/parameters names them. */
  readonly parameters?: Readonly<Record<string, boolean | number | string>>;
}

/**
 * The pose graph of a trajectory: its loops, worst first. `tried` is their number including the rejected ones. `nodes`
 * and `odometry` are the numbers of nodes and of odometry edges. `changed` says whether the graph differs from the
 * result of SLAM.
 */
export interface PoseGraphAnswer {
  readonly trajectory: string;
  readonly nodes: number;
  readonly odometry: number;
  readonly loops: readonly LoopAnswer[];
  readonly tried: number;
  readonly robust: string;
  readonly robust_scale: number;
  readonly changed: boolean;
}

/** The mean errors of a `trajectory`, and `published` ones on the `benchmark` that the file's name states. */
export interface PoseScore {
  readonly relations: number;
  readonly policy: string;
  readonly left_out: number;
  readonly all: MeanErrors;
  readonly unambiguous: MeanErrors | null;
  readonly trajectory: string;
  readonly benchmark: string | null;
  readonly published: readonly PublishedResult[];
}

/** The pose graph of the current trajectory; `graph` is null if it has none. */
export interface PresentGraph {
  readonly graph: PoseGraphAnswer | null;
}

/** The history of the filter that estimated the current poses; `course` is null without localization. */
export interface PresentHistory {
  readonly course: FilterHistory | null;
}

/**
 * The mean error of a program's poses over the relations of a log, metres and degrees; null: not published. `policy` is
 * the mapping of stamps, as in :attr:`mapper.evaluation.relations.RelationErrors.policy`, or "paper" for that of the
 * source. `count` is the number of relations, if known.
 */
export interface PublishedResult {
  readonly program: string;
  readonly translation: number;
  readonly translation_std: number | null;
  readonly rotation: number | null;
  readonly rotation_std: number | null;
  readonly policy: string;
  readonly source: string;
  readonly count: number | null;
}

/** Puzzles included in the program, faults that can be added to a map, and this visitor's own puzzles. */
export interface PuzzleList {
  readonly puzzles: readonly OfferedPuzzle[];
  readonly faults: readonly NamedCause[];
  readonly mine: readonly MadePuzzleAnswer[];
}

/** A puzzle for a class. */
export interface PuzzleOfClass {
  /** Name of a puzzle of the program, or token of one that was made. */
  readonly puzzle: string;
}

/** Number of queued logs. */
export interface QueuedLogs {
  readonly queued: number;
}

/** Two maps that are both shown, and the reason why their cells cannot be compared. */
export interface RefusedComparison {
  readonly a: SecondMap | null;
  readonly refused: string;
}

/** Statistics of relative errors over `delta` of a `unit`. */
export interface RelativeFigures {
  readonly translation_m: ErrorStatistics;
  readonly rotation_rad: ErrorStatistics;
  readonly delta: number;
  readonly unit: string;
  readonly pairs: number;
}

/** What repairs the map, without the values: names of parameters, and whether other poses are needed. */
export interface RepairedWith {
  readonly parameters: readonly string[];
  readonly poses: boolean;
}

/**
 * The edges that determine the pose of a scan, the greatest residual first. `scan` is the scan of the graph's node
 * nearest to the requested scan.
 */
export interface ScanConstraints {
  readonly scan: number;
  readonly edges: readonly ConstraintAnswer[];
}

/** The end points of two scans, metres. `aligned` are those of the later scan, placed by a loop's measurement. */
export interface ScanPoints {
  readonly i: readonly (readonly [number, number])[];
  readonly j: readonly (readonly [number, number])[];
  readonly aligned: readonly (readonly [number, number])[] | null;
}

/** The series of a log's scans along a trajectory. `times` are scan numbers if `axis` is "scan". */
export interface ScanSeries {
  readonly topic: string;
  readonly type: string;
  readonly samples: number;
  readonly gaps: readonly (readonly [number, number])[];
  readonly times: readonly number[];
  readonly columns: readonly SeriesColumn[];
  readonly axis: "time" | "scan";
  readonly trajectory: string;
}

/**
 * A 3D view: cameras, visibility of layers, height of the columns, metres between the lines of the grid. `camera` is
 * the visitor's last choice; null if there is none yet.
 */
export interface SceneAnswer {
  readonly cameras: readonly ("overview" | "above" | "south" | "west" | "north" | "east" | "follow" | "first person")[];
  readonly camera: "overview" | "above" | "south" | "west" | "north" | "east" | "follow" | "first person" | null;
  readonly layers: Readonly<Record<string, boolean>>;
  readonly height: number;
  readonly grid: number;
}

/** Changes of a 3D view: camera, height of the columns, visible layers. */
export interface SceneSettings {
  readonly camera?: "overview" | "above" | "south" | "west" | "north" | "east" | "follow" | "first person" | null;
  readonly height?: number | null;
  readonly layers?: Readonly<Record<string, boolean>>;
}

/**
 * The match score of an edge's later scan against the earlier one, at poses around the edge's measurement. `scores` are
 * in percent: `size` rows of `size` cells of `cell_m` metres, from the least y. Each is the best over the angles, which
 * are `turn_deg` apart; `turn_of` is the index of that angle. `by_turn` is the greatest score at each angle. `centre`
 * is the later scan's pose according to the edge, `present` its pose in the map.
 */
export interface ScoreLandscape {
  readonly edge: number;
  readonly cell_m: number;
  readonly turn_deg: number;
  readonly size: number;
  readonly scores: readonly number[];
  readonly turn_of: readonly number[];
  readonly by_turn: readonly number[];
  readonly centre: readonly [number, number, number];
  readonly present: readonly [number, number, number];
}

/** Map A: the parameters in which it differs from the session's, its trajectory, and its log (null: the same). */
export interface SecondMap {
  readonly values: Readonly<Record<string, boolean | number | string>>;
  readonly with_faults: boolean;
  readonly trajectory: string;
  readonly log: string | null;
  readonly topic: string | null;
  readonly title: string;
}

/** The mapped sensor, null for the log's default, and the options for cutting its scans. */
export interface SensorAnswer {
  readonly topic: string | null;
  readonly cut: Readonly<Record<string, number>>;
}

/**
 * The numbers of a topic's messages, or of a log's scans: `times` in seconds, `samples` before downsampling. `gaps` are
 * pauses of the recording, from one sample to the next, in seconds.
 */
export interface SeriesAnswer {
  readonly topic: string;
  readonly type: string;
  readonly samples: number;
  readonly gaps: readonly (readonly [number, number])[];
  readonly times: readonly number[];
  readonly columns: readonly SeriesColumn[];
}

/** One number over time. */
export interface SeriesColumn {
  readonly label: string;
  readonly unit: string;
  readonly plot: string;
  readonly values: readonly (number | null)[];
}

/** Absolute and relative errors over time. */
export interface SeriesOfErrors {
  readonly absolute: ErrorsOverTime;
  readonly relative: ErrorsOverTime;
}

/** A session: the map has `index` of `count` scans, and `watching` clients receive its `stream`. */
export interface SessionAnswer {
  readonly id: string;
  readonly kind: string;
  readonly title: string;
  readonly stream: string;
  readonly playing: boolean;
  readonly index: number;
  readonly count: number;
  readonly watching: number;
}

/** Sessions that a visitor began. */
export interface SessionList {
  readonly sessions: readonly SessionAnswer[];
}

/**
 * A link as seen by its receivers; `look` is the visible part of the map, null for all of it. `shown` are other parts
 * of the page that its sender saw, null if the link does not contain them; `examination` is the diagnosis of the log,
 * null if it had not been examined.
 */
export interface SharedAnswer {
  readonly title: string;
  readonly look: Look | null;
  readonly shown: Shown | null;
  readonly examination: DoctorAnswer | null;
}

/** The title of a visitor's puzzle. */
export interface SharedPuzzle {
  readonly title: string;
}

/** Other parts of the page that its sender saw. */
export interface Shown {
  /** The open group of controls. */
  readonly group: string | null;
  /** Id of the chosen note. */
  readonly note: string | null;
  /** The views beside the map, as the page writes them. */
  readonly layout: string | null;
  /** The topic whose messages are shown. */
  readonly message: string | null;
  /** The topic whose pictures are shown. */
  readonly picture: string | null;
  readonly plots: ShownPlots | null;
  readonly lines: ShownLines | null;
  /** The explained cell's place, metres. */
  readonly place: readonly [number, number] | null;
  readonly measured: ShownMeasure | null;
  readonly scene: ShownScene | null;
  /** Whether times are in UTC. */
  readonly utc: boolean | null;
  /** The comparison, as the page writes it. */
  readonly comparison: string | null;
}

/** Camera of a 3D view. */
export interface ShownCamera {
  /** Where it is, metres. */
  readonly position: readonly [number, number, number];
  /** What it looks at, metres. */
  readonly look_at: readonly [number, number, number];
}

/** A plotted number. */
export interface ShownField {
  readonly topic: string;
  /** Its path in the message. */
  readonly field: string;
  /** The value, its change per second, or its moving average. */
  readonly made: "value" | "derivative" | "average";
  /** Window of the moving average, seconds. */
  readonly window: number;
}

/** Filter of the lines logged by nodes. */
export interface ShownLines {
  /** The least level. */
  readonly least: number;
  /** The node; empty for all. */
  readonly node: string;
  /** What they contain. */
  readonly text: string;
}

/** A measurement on the map or in 3D. */
export interface ShownMeasure {
  readonly tool: "distance" | "area";
  /** Metres; with a height where they were measured in 3D. */
  readonly points: readonly (readonly [number, number] | readonly [number, number, number])[];
  /** Side of the largest voxel that one is on, metres; 0: all are measured points. */
  readonly size: number | null;
}

/** The plots of a log. */
export interface ShownPlots {
  readonly fields: readonly ShownField[];
  /** The number on the horizontal axis; null for time. */
  readonly across: string | null;
  /** The interval, seconds; null for all. */
  readonly zoom: readonly [number, number] | null;
  /** Whether there are plots below the time slider. */
  readonly below: boolean;
}

/** The 3D view of the stage. */
export interface ShownScene {
  /** Whether it shows the log's point clouds, not its map. */
  readonly clouds: boolean;
  /** Null: as at first. */
  readonly camera: ShownCamera | null;
  /** Whether each layer is visible. */
  readonly layers: Readonly<Record<string, boolean>>;
  /** Height of the map's columns by that at first. */
  readonly height: number;
  /** The camera that was chosen, unless it was moved elsewhere then; null: as at first. */
  readonly chosen: "overview" | "above" | "south" | "west" | "north" | "east" | "follow" | "first person" | null;
  /** Values of the table of the clouds' look, such as point_size. */
  readonly look: Readonly<Record<string, boolean | number | string>>;
}

/** The history of a simulation, with its initial world and seed. */
export interface SimulationHistory {
  /** Name of the world. */
  readonly world: string;
  /** Seed of the random numbers. */
  readonly seed: number;
  /** Initial values of the simulated sensor. */
  readonly sensor: Readonly<Record<string, boolean | number | string>>;
  /** Initial edits of the world. */
  readonly edits: WorldEdits;
  /** Physics steps of 0.02 s since the beginning. */
  readonly steps: number;
  /** Each action with the step before which it was carried out; null if only the pose is known. */
  readonly journal: readonly (readonly [number, Readonly<Record<string, unknown>>])[] | null;
  /** Final pose of the robot, if journal is null. */
  readonly pose: readonly [number, number, number] | null;
  /** Whether the robot explores by itself then. */
  readonly auto: boolean;
  /** Mapping parameters that differ from the initial ones. */
  readonly parameters: Readonly<Record<string, boolean | number | string>>;
  /** The robot's faults. */
  readonly faults: Readonly<Record<string, boolean | number | string>>;
  /** Simulated seconds per second. */
  readonly speed: number | null;
  /** Whether the session plays. */
  readonly playing: boolean;
  /** The commands that begin the costmap and set the goal of its path. */
  readonly navigation: readonly (Readonly<Record<string, unknown>>)[];
}

/** Result of SLAM for a log: `trajectory` is the name of the new one; figures of the map before and after. */
export interface SlamResult {
  readonly trajectory: string;
  readonly odometry: string | null;
  readonly loops: number;
  readonly nodes: number;
  readonly cpu_s: number;
  readonly drift_m: readonly [number | null, number | null];
  readonly contradicted: readonly [number | null, number | null];
  readonly sharpness: readonly [number | null, number | null];
  readonly notes: readonly string[];
}

/** State of SLAM for a log: the `stage`, the number of scans with poses, and the number of closed loops. */
export interface SlamStatus {
  readonly state: "none" | "queued" | "running" | "done" | "failed" | "cancelled";
  readonly created_s: number;
  readonly error: Failure | null;
  readonly fraction: number;
  readonly elapsed_s: number | null;
  readonly ahead: number;
  readonly log: string;
  readonly topic: string | null;
  readonly odometry: string | null;
  readonly parameters: Readonly<Record<string, boolean | number | string>>;
  readonly result: SlamResult | null;
  readonly stage: string | null;
  readonly scans: number;
  readonly loops: number;
}

/**
 * The answer to a puzzle: its cause, a `lesson` about it from a `section`, and the repair of the map. `repair` has the
 * parameters that repair it, `faulty` their initial values; `trajectory` the poses that repair it, null for the initial
 * ones, `faulty_trajectory`.
 */
export interface SolutionAnswer {
  readonly cause: string;
  readonly label: string;
  readonly explanation: string;
  readonly lesson: string;
  readonly section: string;
  readonly repair: Readonly<Record<string, boolean | number | string>>;
  readonly trajectory: string | null;
  readonly faulty: Readonly<Record<string, boolean | number | string>>;
  readonly faulty_trajectory: string;
}

/** The tags of a log. */
export interface TagsOfLog {
  readonly tags: readonly string[];
}

/** Numbers of patches of each class. */
export interface TerrainCounts {
  readonly safe: number;
  readonly unsafe: number;
  readonly unknown: number;
}

/** A terrain among the visitor's uploads. */
export interface TerrainOfUpload {
  /** Id of the cloud or map, as in /api/logs; null: none. */
  readonly log: string | null;
}

/**
 * Times of the scans. `start_s` is the earliest stamp since 1970, null for a clock with another epoch. A gap is a pause
 * between two scans of more than a second and five times the usual one; `longest_gap_at_s` is the start of the longest,
 * in seconds since the earliest stamp.
 */
export interface TimeSummary {
  readonly start_s: number | null;
  readonly rate_hz: number | null;
  readonly gaps: number;
  readonly longest_gap_s: number;
  readonly longest_gap_at_s: number;
}

/**
 * One stream of messages in the file of a log. `frame` to `mount` apply to range sensors and are null for others:
 * `frame` is the frame of its scans, `mount` is `T_base_frame` (m, m, rad) if the file states it; `chosen` marks the
 * sensor whose scans the log contains. :mod:`mapper.io.contents` determines the times and sizes of its messages.
 */
export interface Topic {
  readonly name: string;
  readonly type: string;
  readonly count: number;
  readonly frame: string | null;
  readonly beams: number | null;
  readonly field_of_view_deg: number | null;
  readonly rate_hz: number | null;
  readonly mount: readonly [number, number, number] | null;
  readonly chosen: boolean;
}

/**
 * A topic of the recording. Times are seconds since the log's first scan, null for topics without times. They are
 * recording times, minus the delay from the stamp of that scan to its recording. `mapped` says whether the map uses the
 * topic, null if no map can be made from it; `cut` whether it has clouds or images from which scans can be cut.
 */
export interface TopicAnswer {
  readonly name: string;
  readonly type: string;
  readonly messages: number;
  readonly bytes: number;
  readonly rate_hz: number | null;
  readonly first_s: number | null;
  readonly last_s: number | null;
  readonly mapped: boolean | null;
  readonly cut: boolean;
}

/**
 * The numbers of a topic that can be plotted, by the paths of their fields; `why` there are none, else empty.
 * `computed` says that they do not come from a topic, but are computed from the log's scans, its map or its pose graph.
 * `frames` are the coordinate frames in its first message (`frame_id` and `child_frame_id`).
 */
export interface TopicFieldsAnswer {
  readonly topic: string;
  readonly type: string;
  readonly fields: readonly string[];
  readonly why: string;
  readonly frames: readonly string[];
  readonly computed: boolean;
}

/**
 * A trajectory of a log: its own (`source` is "log"), or one that the visitor has added. `created_s` is when it was
 * added, seconds since 1970; `has_graph` says whether its pose graph is stored.
 */
export interface TrajectoryAnswer {
  readonly name: string;
  readonly description: string;
  readonly length_m: number;
  readonly source: "log" | "tum" | "slam" | "localized";
  readonly created_s: number | null;
  readonly has_graph: boolean;
}

/** The errors of a trajectory: figures, errors over time, both paths. */
export interface TrajectoryErrors {
  readonly pairs: number;
  readonly alignment: Alignment;
  readonly absolute: ErrorFigures;
  readonly relative: RelativeFigures;
  readonly series: SeriesOfErrors;
  readonly paths: ComparedPaths;
}

/** A loop that SLAM tried, `away_m` metres from a place. `reason` is why it was rejected, empty if accepted. */
export interface TriedLoop {
  readonly candidate: number;
  readonly scans: readonly [number, number];
  readonly away_m: number;
  readonly score: number;
  readonly inliers: number;
  readonly accepted: boolean;
  readonly reason: string;
}

/** A loop that SLAM tried, with both of its scans. */
export interface TriedLoopScans {
  readonly candidate: number;
  readonly scans: readonly [number, number];
  readonly away_m: number;
  readonly score: number;
  readonly inliers: number;
  readonly accepted: boolean;
  readonly reason: string;
  readonly poses: readonly (readonly [number, number, number])[];
  readonly points: ScanPoints;
}

/**
 * The loops that were tried near a place. `visits` are the runs of scans (first and last) recorded near it. `pair` is a
 * scan of the first visit and one of the last, which a loop could join; null if there are not two visits.
 */
export interface TriedNear {
  readonly visits: readonly (readonly [number, number])[];
  readonly pair: readonly [number, number] | null;
  readonly candidates: readonly TriedLoop[];
}

/** The number of received bytes of an upload, where the next part starts; `total` is known with the first part. */
export interface UploadOffset {
  readonly offset: number;
  readonly total: number | null;
}

/** A simulated world; `bounds` are the least and greatest x and y, metres. */
export interface WorldAnswer {
  readonly name: string;
  readonly title: string;
  readonly bounds: readonly [number, number, number, number];
}

/** Edits of a world, as in the `edit` command. */
export interface WorldEdits {
  /** Walls and boxes that were drawn. */
  readonly added: readonly (readonly (string | number)[])[];
  /** Indices of the built solids that were erased. */
  readonly erased: readonly number[];
}

/** The simulated worlds. */
export interface WorldList {
  readonly worlds: readonly WorldAnswer[];
}

/** The query of each request that has one, by method and address. */
export interface Queries {
  "GET /api/fleet": {
    readonly since?: number;
  };
  "GET /api/links": {
    readonly log: string;
  };
  "GET /api/logs": {
    readonly q?: string;
    readonly tag?: readonly string[];
    readonly order?: "newest" | "name" | "duration" | "scans" | "size";
    readonly offset?: number;
    readonly limit?: number;
  };
  "GET /api/logs/{log_id}/map.png": {
    readonly dark?: boolean;
  };
  "GET /api/puzzles/{puzzle}/map.png": {
    readonly dark?: boolean;
  };
  "GET /api/sessions/{session_id}/contents/camera": {
    readonly topic: string;
    readonly x: number;
    readonly y: number;
    readonly at?: number;
  };
  "GET /api/sessions/{session_id}/contents/field": {
    readonly topic: string;
    readonly field: string;
    readonly made?: "value" | "derivative" | "average";
    readonly window?: number;
    readonly start?: number;
    readonly end?: number;
    readonly buckets?: number;
    readonly evenly?: boolean;
  };
  "GET /api/sessions/{session_id}/contents/frame_age": {
    readonly tf: string;
    readonly parent: string;
    readonly child: string;
    readonly buckets?: number;
  };
  "GET /api/sessions/{session_id}/contents/frames": {
    readonly at?: number;
    readonly fixed?: string;
    readonly tf?: string;
  };
  "GET /api/sessions/{session_id}/contents/message": {
    readonly topic: string;
    readonly at?: number;
  };
  "GET /api/sessions/{session_id}/contents/picture": {
    readonly topic: string;
    readonly at?: number;
  };
  "GET /api/sessions/{session_id}/contents/series": {
    readonly topic: string;
    readonly start?: number;
    readonly end?: number;
    readonly buckets?: number;
  };
  "GET /api/sessions/{session_id}/doctor": {
    readonly name?: string;
  };
  "GET /api/sessions/{session_id}/graph/candidates": {
    readonly x: number;
    readonly y: number;
  };
  "GET /api/sessions/{session_id}/map.pgm": {
    readonly at?: string;
  };
  "GET /api/sessions/{session_id}/map.yaml": {
    readonly at?: string;
  };
  "GET /api/sessions/{session_id}/scan-series": {
    readonly start?: number;
    readonly end?: number;
    readonly buckets?: number;
  };
  "GET /api/sessions/{session_id}/trajectory-errors": {
    readonly reference: string;
    readonly estimate: string;
    readonly align?: "rigid" | "scaled" | "origin" | "none";
    readonly delta?: number;
    readonly unit?: "m" | "s" | "frames";
  };
  "POST /api/classes/{code}/puzzle/sessions": {
    readonly name?: string;
  };
  "POST /api/localization/amcl.yaml": {
    readonly layout?: "nav2" | "ros1";
  };
  "POST /api/puzzles/{puzzle}/sessions": {
    readonly name?: string;
  };
  "POST /api/shared-puzzles/{token}/sessions": {
    readonly name?: string;
  };
  "POST /api/shared/{token}/sessions": {
    readonly name?: string;
    readonly whole?: boolean;
    readonly clouds?: boolean;
  };
  "PUT /api/logs": {
    readonly name?: string;
    readonly upload?: string;
    readonly sha256?: string;
  };
  "PUT /api/sessions/{session_id}/localization/map-files": {
    readonly name?: string;
  };
  "PUT /api/sessions/{session_id}/relations": {
    readonly name?: string;
  };
  "PUT /api/sessions/{session_id}/sensor": {
    readonly name?: string;
  };
}

/** The body of each request that has one, by method and address. */
export interface Bodies {
  "POST /api/fleet": FleetRequest;
  "POST /api/localization/amcl.yaml": Readonly<Record<string, unknown>>;
  "POST /api/logs/{log_id}/slam": NewSlam;
  "POST /api/sessions": NewSimulation | NewLog | NewVolume;
  "POST /api/sessions/{session_id}/edited-map": NewMap;
  "POST /api/sessions/{session_id}/graph": ChangeOfGraph;
  "POST /api/sessions/{session_id}/heal": PoseCorrection | null;
  "POST /api/sessions/{session_id}/kept-map": NewMap;
  "POST /api/sessions/{session_id}/links": NewLink;
  "POST /api/sessions/{session_id}/localization": NewLocalization;
  "POST /api/sessions/{session_id}/merge": OtherLog;
  "POST /api/sessions/{session_id}/notes": NewNote;
  "POST /api/sessions/{session_id}/puzzle/answer": AttemptAnswer;
  "POST /api/sessions/{session_id}/puzzles": NewPuzzle;
  "POST /scenes/{session_id}/settings": SceneSettings;
  "PUT /api/classes/{code}/puzzle": PuzzleOfClass;
  "PUT /api/localization/parameters": Blob;
  "PUT /api/logs": Blob;
  "PUT /api/logs/{log_id}/tags": TagsOfLog;
  "PUT /api/logs/{log_id}/trajectories/{name}": Blob;
  "PUT /api/sessions/{session_id}/compare": ComparedMap;
  "PUT /api/sessions/{session_id}/costmap/footprint": FootprintOfCostmap;
  "PUT /api/sessions/{session_id}/costmap/terrain": TerrainOfUpload;
  "PUT /api/sessions/{session_id}/localization/map": MapOfLog;
  "PUT /api/sessions/{session_id}/localization/map-files": Blob;
  "PUT /api/sessions/{session_id}/notes/{note_id}": NewNote;
  "PUT /api/sessions/{session_id}/relations": Blob;
  "PUT /api/sessions/{session_id}/sensor": NewSensor;
  "PUT /api/sessions/{session_id}/trajectories/{name}": Blob;
}

/** The answer to each request, by method and address. */
export interface Answers {
  "DELETE /api/classes/{code}": undefined;
  "DELETE /api/classes/{code}/puzzle": undefined;
  "DELETE /api/fleet": undefined;
  "DELETE /api/links/{token}": undefined;
  "DELETE /api/logs/uploads/{key}": undefined;
  "DELETE /api/logs/{log_id}": undefined;
  "DELETE /api/logs/{log_id}/slam": SlamStatus;
  "DELETE /api/logs/{log_id}/trajectories/{name}": undefined;
  "DELETE /api/puzzles/{token}": undefined;
  "DELETE /api/sessions/{session_id}": undefined;
  "DELETE /api/sessions/{session_id}/compare": undefined;
  "DELETE /api/sessions/{session_id}/contents": undefined;
  "DELETE /api/sessions/{session_id}/heal": SlamStatus;
  "DELETE /api/sessions/{session_id}/links/{token}": undefined;
  "DELETE /api/sessions/{session_id}/localization": LocalizationStatus;
  "DELETE /api/sessions/{session_id}/merge": MergeStatus;
  "DELETE /api/sessions/{session_id}/notes/{note_id}": undefined;
  "DELETE /api/sessions/{session_id}/trajectories/{name}": undefined;
  "GET /api/classes": OpenClassAnswer | undefined;
  "GET /api/classes/{code}": ClassAnswer;
  "GET /api/fleet": FleetState;
  "GET /api/links": LinkList;
  "GET /api/localization/parameters": ParameterTable;
  "GET /api/logs": LogList;
  "GET /api/logs/uploads/{key}": UploadOffset;
  "GET /api/logs/{log_id}": LogAnswer;
  "GET /api/logs/{log_id}/slam": SlamStatus;
  "GET /api/parameters": ParameterTables;
  "GET /api/puzzles": PuzzleList;
  "GET /api/sessions": SessionList;
  "GET /api/sessions/making/{name}": MakingAnswer | undefined;
  "GET /api/sessions/{session_id}": SessionAnswer;
  "GET /api/sessions/{session_id}/compare": ComparisonAnswer;
  "GET /api/sessions/{session_id}/contents": ContentsAnswer | ContentsReading;
  "GET /api/sessions/{session_id}/contents/camera": CameraAnswer;
  "GET /api/sessions/{session_id}/contents/field": SeriesAnswer | ContentsReading;
  "GET /api/sessions/{session_id}/contents/fields": FieldsAnswer | ContentsReading;
  "GET /api/sessions/{session_id}/contents/frame_age": SeriesAnswer;
  "GET /api/sessions/{session_id}/contents/frames": FramesAnswer;
  "GET /api/sessions/{session_id}/contents/lines": LinesAnswer;
  "GET /api/sessions/{session_id}/contents/message": MessageAnswer;
  "GET /api/sessions/{session_id}/contents/series": SeriesAnswer;
  "GET /api/sessions/{session_id}/costmap/footprint": FootprintAnswer;
  "GET /api/sessions/{session_id}/doctor": DoctorAnswer;
  "GET /api/sessions/{session_id}/graph": PresentGraph;
  "GET /api/sessions/{session_id}/graph/candidates": TriedNear;
  "GET /api/sessions/{session_id}/graph/candidates/{candidate}": TriedLoopScans;
  "GET /api/sessions/{session_id}/graph/edges/{edge}": EdgeAnswer;
  "GET /api/sessions/{session_id}/graph/edges/{edge}/landscape": ScoreLandscape;
  "GET /api/sessions/{session_id}/graph/scans/{scan}": ScanConstraints;
  "GET /api/sessions/{session_id}/heal": SlamStatus;
  "GET /api/sessions/{session_id}/links": LinkList;
  "GET /api/sessions/{session_id}/localization": LocalizationStatus;
  "GET /api/sessions/{session_id}/localization/course": PresentHistory;
  "GET /api/sessions/{session_id}/localization/map": ChosenMap;
  "GET /api/sessions/{session_id}/merge": MergeStatus;
  "GET /api/sessions/{session_id}/notes": NoteList;
  "GET /api/sessions/{session_id}/puzzle": Attempt;
  "GET /api/sessions/{session_id}/scan-series": ScanSeries;
  "GET /api/sessions/{session_id}/story": SimulationHistory;
  "GET /api/sessions/{session_id}/trajectory-errors": TrajectoryErrors;
  "GET /api/shared-puzzles/{token}": SharedPuzzle;
  "GET /api/shared/{token}": SharedAnswer;
  "GET /api/slam/parameters": ParameterTable;
  "GET /api/worlds": WorldList;
  "GET /livez": Health;
  "GET /readyz": Health;
  "GET /scenes/{session_id}/settings": SceneAnswer;
  "POST /api/classes": OpenClassAnswer;
  "POST /api/classes/{code}/puzzle/sessions": SessionAnswer;
  "POST /api/classes/{code}/sessions": SessionAnswer;
  "POST /api/fleet": QueuedLogs;
  "POST /api/logs/examples/{name}": LogAnswer;
  "POST /api/logs/{log_id}/cancel": LogAnswer;
  "POST /api/logs/{log_id}/read": LogAnswer;
  "POST /api/logs/{log_id}/slam": SlamStatus;
  "POST /api/puzzles/{puzzle}/sessions": SessionAnswer;
  "POST /api/sessions": SessionAnswer;
  "POST /api/sessions/{session_id}/edited-map": LogAnswer;
  "POST /api/sessions/{session_id}/graph": PresentGraph;
  "POST /api/sessions/{session_id}/graph/keep": TrajectoryAnswer;
  "POST /api/sessions/{session_id}/heal": SlamStatus;
  "POST /api/sessions/{session_id}/kept-map": LogAnswer;
  "POST /api/sessions/{session_id}/links": LinkAnswer;
  "POST /api/sessions/{session_id}/localization": LocalizationStatus;
  "POST /api/sessions/{session_id}/merge": MergeStatus;
  "POST /api/sessions/{session_id}/notes": NoteAnswer;
  "POST /api/sessions/{session_id}/puzzle/answer": Attempt;
  "POST /api/sessions/{session_id}/puzzle/check": Attempt;
  "POST /api/sessions/{session_id}/puzzle/hint": Attempt;
  "POST /api/sessions/{session_id}/puzzle/solution": Attempt;
  "POST /api/sessions/{session_id}/puzzles": MadePuzzleAnswer;
  "POST /api/shared-puzzles/{token}/sessions": SessionAnswer;
  "POST /api/shared/{token}/sessions": SessionAnswer;
  "POST /scenes/{session_id}/settings": SceneAnswer;
  "PUT /api/classes/{code}/puzzle": undefined;
  "PUT /api/localization/parameters": AmclParameters;
  "PUT /api/logs": LogAnswer;
  "PUT /api/logs/{log_id}/tags": LogAnswer;
  "PUT /api/logs/{log_id}/trajectories/{name}": AddedTrajectory;
  "PUT /api/sessions/{session_id}/compare": ComparisonAnswer | RefusedComparison;
  "PUT /api/sessions/{session_id}/costmap/footprint": FootprintAnswer;
  "PUT /api/sessions/{session_id}/costmap/terrain": ChosenMap;
  "PUT /api/sessions/{session_id}/localization/map": ChosenMap;
  "PUT /api/sessions/{session_id}/localization/map-files": ChosenMap;
  "PUT /api/sessions/{session_id}/notes/{note_id}": NoteAnswer;
  "PUT /api/sessions/{session_id}/relations": PoseScore;
  "PUT /api/sessions/{session_id}/sensor": SensorAnswer;
  "PUT /api/sessions/{session_id}/trajectories/{name}": AddedTrajectory;
}

/** The requests that are answered with a file. */
export type Files =
  | "GET /api/classes/{code}/qr.svg"
  | "GET /api/classes/{code}/results.csv"
  | "GET /api/logs/{log_id}/map.png"
  | "GET /api/logs/{log_id}/trajectories/{name}"
  | "GET /api/puzzles/{puzzle}/map.png"
  | "GET /api/sessions/{session_id}/above.pgm"
  | "GET /api/sessions/{session_id}/above.yaml"
  | "GET /api/sessions/{session_id}/compare.png"
  | "GET /api/sessions/{session_id}/contents/picture"
  | "GET /api/sessions/{session_id}/costmap/{name}"
  | "GET /api/sessions/{session_id}/depth.png"
  | "GET /api/sessions/{session_id}/edited-map/{name}"
  | "GET /api/sessions/{session_id}/map.pgm"
  | "GET /api/sessions/{session_id}/map.png"
  | "GET /api/sessions/{session_id}/map.yaml"
  | "GET /api/sessions/{session_id}/notes.csv"
  | "GET /api/sessions/{session_id}/notes.geojson"
  | "GET /api/sessions/{session_id}/report"
  | "GET /api/sessions/{session_id}/report.pdf"
  | "GET /api/sessions/{session_id}/run.mcap"
  | "GET /api/sessions/{session_id}/selection.ply"
  | "GET /api/sessions/{session_id}/surface.glb"
  | "GET /api/sessions/{session_id}/surface.ply"
  | "GET /api/sessions/{session_id}/trajectories/{name}"
  | "GET /api/sessions/{session_id}/trajectory.tum"
  | "GET /api/sessions/{session_id}/volume.bt"
  | "GET /api/sessions/{session_id}/volume.ot"
  | "GET /metrics"
  | "POST /api/localization/amcl.yaml";
