// Written by `python -m server.http_types` from the answers of the routes in server/http/routes: change those.

/** A trajectory that was added, with notes on how it was joined to the scans. */
export interface AddedTrajectory {
  readonly name: string;
  readonly description: string;
  readonly length_m: number;
  readonly source: "log" | "tum" | "slam" | "localized";
  readonly created_s: number | null;
  readonly has_graph: boolean;
  readonly notes: readonly string[];
}

/** Workers that map logs, and how many logs they map at once; `error` says why there are none or fewer. */
export interface ClusterState {
  readonly workers: number;
  readonly threads: number;
  readonly error: string;
}

/** Error of a job that failed: a stable code and one sentence. */
export interface Failure {
  readonly code: string;
  readonly message: string;
}

/**
 * What is known of a log that was mapped; the map has cells of `resolution` metres, `contrast` of its walls. `cpu_s`
 * and `seconds` are processor and elapsed time, `runs` how many it took.
 */
export interface FleetFacts {
  readonly scans: number;
  readonly beams: number;
  readonly trajectory: string;
  readonly rows: number;
  readonly cols: number;
  readonly resolution: number;
  readonly contrast: number | null;
  readonly findings: readonly FleetFinding[];
  readonly picture: boolean;
  readonly cpu_s: number;
  readonly seconds: number;
  readonly runs: number;
}

/** What the log doctor found: its `check`, in a `sentence`; `possible` where it may be something else. */
export interface FleetFinding {
  readonly check: string;
  readonly sentence: string;
  readonly possible: boolean;
}

/** A log of the fleet; `fraction` is the share of its job that is done, `facts` what was found out. */
export interface FleetLog {
  readonly id: string;
  readonly name: string;
  readonly state: "none" | "queued" | "running" | "done" | "failed";
  readonly fraction: number;
  readonly error: Failure | null;
  readonly facts: FleetFacts | null;
}

/**
 * How many logs are in which state, and those that have changed since a revision. `whole` says that all are returned:
 * of revision 0, and where a log was forgotten since. `cluster` is null where processes of this machine do it; its
 * address is not told.
 */
export interface FleetState {
  readonly revision: number;
  readonly whole: boolean;
  readonly workers: number;
  readonly cluster: ClusterState | null;
  readonly counts: Readonly<Record<"none" | "queued" | "running" | "done" | "failed", number>>;
  readonly logs: readonly FleetLog[];
}

/**
 * A link as its owner sees it: the view that it opens, and how many are `watching`. `count` is the number of scans of
 * the log, `index` how many of them the map has; `changed` names the parameters with other values than at first.
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

/** `values` that differ from the first ones; `initial_pose` is in the map, x, y (m) and yaw, null: anywhere. */
export interface LocalizationParameters {
  readonly values: Readonly<Record<string, boolean | number | string>>;
  readonly initial_pose: readonly [number, number, number] | null;
}

/** What localization has made of a log: `trajectory` is its name. */
export interface LocalizationResult {
  readonly map_title: string;
  readonly odometry: string;
  readonly first_converged: number | null;
  readonly converged: number;
  readonly is_converged: boolean;
  readonly updates: number;
  readonly median_fit: number;
  readonly cpu_s: number;
  readonly trajectory: string;
}

/** State of the localization of a log: how many scans have poses, and whether the filter has converged. */
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
 * A log as the HTTP interface shows it. Facts are null until the log was read. `reading_s` are seconds since its
 * reading began, null while it is not being read; `tags` are the visitor's own. `costmaps` is how many there are in a
 * recording without scans, `clouds` the number of scans in 3D of a file without planar ones (an octree counts as one)
 * and `points` those in them, or leaves of the octree. `topics` are the streams of messages in the file, its sensors
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

/** The logs of one page of a list, how many were found, and the visitor's tags with the number of logs of each. */
export interface LogList {
  readonly logs: readonly LogAnswer[];
  readonly total: number;
  readonly tags: Readonly<Record<string, number>>;
}

/** The size of a map in cells, and the side of a cell in metres. */
export interface MapSummary {
  readonly rows: number;
  readonly cols: number;
  readonly resolution: number;
}

/** What a merge has made: `trajectory` of both logs, and the log of both, its id and its name. */
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
 * A message of a recording: topic, type, size, and the `fields` by name, as `ros2 topic echo` has them. `seconds` is
 * when it was recorded, from the log's first scan; `stamp_ns` the same since 1970, as text, as JSON's numbers are not
 * exact there. Arrays are cut after their first elements, with a text that says how many follow.
 */
export interface MessageAnswer {
  readonly topic: string;
  readonly type: string;
  readonly seconds: number;
  readonly stamp_ns: string;
  readonly bytes: number;
  readonly fields: Readonly<Record<string, unknown>>;
}

/** A note as the HTTP interface shows it, with the fields of its :class:`Pin`; `mine` is the asking visitor's. */
export interface NoteAnswer {
  readonly id: string;
  readonly text: string;
  readonly at_s: number | null;
  readonly scan: number | null;
  readonly x: number | null;
  readonly y: number | null;
  readonly created_s: number;
  readonly changed_s: number;
  readonly mine: boolean;
}

/** The notes on a log, oldest first. */
export interface NoteList {
  readonly notes: readonly NoteAnswer[];
}

/** How many logs were queued. */
export interface QueuedLogs {
  readonly queued: number;
}

/** What SLAM has made of a log: `trajectory` is its name; figures of the map before and after it. */
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

/** State of SLAM of a log: the `stage` as SLAM names it, how many scans have poses, how many loops have closed. */
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
 * Times of the scans. `start_s` is the earliest stamp since 1970, null for a clock that began elsewhere. A gap is a
 * pause of more than a second and five times the usual one between two scans; `longest_gap_at_s` is where the longest
 * begins, in seconds since the earliest stamp.
 */
export interface TimeSummary {
  readonly start_s: number | null;
  readonly rate_hz: number | null;
  readonly gaps: number;
  readonly longest_gap_s: number;
  readonly longest_gap_at_s: number;
}

/**
 * One stream of messages in the file that a log was read from. `frame` to `mount` are those of a range sensor, null of
 * anything else: `frame` is the one that its scans are stated in, `mount` `T_base_frame` (m, m, rad) where the file
 * says it; `chosen` marks the sensor whose scans the log holds. When its messages were recorded and how large they are,
 * :mod:`mapper.io.contents` finds out.
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
 * A trajectory of a log: its own (`source` is "log"), or one that the visitor has added. `created_s` is when it was
 * added, seconds since 1970; `has_graph` says whether its pose graph is kept.
 */
export interface TrajectoryAnswer {
  readonly name: string;
  readonly description: string;
  readonly length_m: number;
  readonly source: "log" | "tum" | "slam" | "localized";
  readonly created_s: number | null;
  readonly has_graph: boolean;
}

/** How many bytes of an upload have arrived: the next part starts there; the `total` is known with the first. */
export interface UploadOffset {
  readonly offset: number;
  readonly total: number | null;
}

/** The answer to each request, by method and address. */
export interface Answers {
  "DELETE /api/logs/{log_id}/slam": SlamStatus;
  "DELETE /api/sessions/{session_id}/heal": SlamStatus;
  "DELETE /api/sessions/{session_id}/localization": LocalizationStatus;
  "DELETE /api/sessions/{session_id}/merge": MergeStatus;
  "GET /api/fleet": FleetState;
  "GET /api/links": LinkList;
  "GET /api/logs": LogList;
  "GET /api/logs/uploads/{key}": UploadOffset;
  "GET /api/logs/{log_id}": LogAnswer;
  "GET /api/logs/{log_id}/slam": SlamStatus;
  "GET /api/sessions/{session_id}/contents/message": MessageAnswer;
  "GET /api/sessions/{session_id}/heal": SlamStatus;
  "GET /api/sessions/{session_id}/links": LinkList;
  "GET /api/sessions/{session_id}/localization": LocalizationStatus;
  "GET /api/sessions/{session_id}/merge": MergeStatus;
  "GET /api/sessions/{session_id}/notes": NoteList;
  "POST /api/fleet": QueuedLogs;
  "POST /api/links": LinkAnswer;
  "POST /api/logs/{log_id}/cancel": LogAnswer;
  "POST /api/logs/{log_id}/read": LogAnswer;
  "POST /api/logs/{log_id}/slam": SlamStatus;
  "POST /api/sessions/{session_id}/edited-map": LogAnswer;
  "POST /api/sessions/{session_id}/graph/keep": TrajectoryAnswer;
  "POST /api/sessions/{session_id}/heal": SlamStatus;
  "POST /api/sessions/{session_id}/kept-map": LogAnswer;
  "POST /api/sessions/{session_id}/localization": LocalizationStatus;
  "POST /api/sessions/{session_id}/merge": MergeStatus;
  "POST /api/sessions/{session_id}/notes": NoteAnswer;
  "PUT /api/logs": LogAnswer;
  "PUT /api/logs/{log_id}/tags": LogAnswer;
  "PUT /api/logs/{log_id}/trajectories/{name}": AddedTrajectory;
  "PUT /api/sessions/{session_id}/notes/{note_id}": NoteAnswer;
  "PUT /api/sessions/{session_id}/trajectories/{name}": AddedTrajectory;
}
