/** What a log's recording holds, as the server finds it out. */

export interface TopicContents {
  readonly name: string;
  readonly type: string;
  readonly messages: number;
  readonly bytes: number;
  readonly rate_hz: number | null;
  /** Seconds since the recording began, null for messages without a time. */
  readonly first_s: number | null;
  readonly last_s: number | null;
  /** Whether the map is made of it; null for what no map can be made of. */
  readonly mapped: boolean | null;
  /** Whether it has clouds or images, out of which scans can be cut. */
  readonly cut: boolean;
}

export interface Contents {
  readonly topics: readonly TopicContents[];
  readonly series: readonly {
    readonly topic: string;
    readonly type: string;
    readonly samples: number;
    readonly plots: readonly string[];
  }[];
  readonly frames: number;
  /** The topics with images or clouds. */
  readonly pictures: readonly string[];
  readonly notes: readonly string[];
}

export interface FrameEdge {
  readonly parent: string;
  readonly child: string;
  readonly static: boolean;
  readonly count: number;
  readonly rate_hz: number | null;
  /** Seconds since the newest transform at the moment, null before the first. */
  readonly age_s: number | null;
  /** False for a second parent of the same frame, which is not followed. */
  readonly used: boolean;
}

export interface Frames {
  /** The topic of these transforms, and all topics that have some: robots may have the same frames on topics of their own. */
  readonly tf: string;
  readonly trees: readonly string[];
  readonly fixed: string;
  readonly sensor: string;
  readonly frames: readonly string[];
  readonly edges: readonly FrameEdge[];
  /** One sentence each. */
  readonly faults: readonly string[];
}

/** The address of a part of a session's contents. */
export function contentsAddress(session: string, part = "", query: Record<string, string> = {}): string {
  const search = new URLSearchParams(query);
  return `/api/sessions/${encodeURIComponent(session)}/contents${part}${search.size > 0 ? `?${search}` : ""}`;
}

/** Fetch JSON. Throws an error with the server's message if it is refused. */
export async function fetchJson<T>(address: string, signal: AbortSignal): Promise<{ status: number; body: T }> {
  const answer = await fetch(address, { signal });
  const body: unknown = await answer.json();
  if (!answer.ok) throw new Error((body as { message?: string }).message ?? "The server refused the request.");
  return { status: answer.status, body: body as T };
}

/** A rate as text: 10.0 Hz, and for slow topics the time between two messages. */
export function rateLabel(rate: number | null): string {
  if (rate === null) return "–";
  if (rate >= 0.1) return `${rate < 100 ? rate.toFixed(1) : Math.round(rate)} Hz`;
  return `every ${Math.round(1 / rate)} s`;
}

/** An age as text: 12 ms, 3.4 s, 2:05. */
export function ageLabel(seconds: number): string {
  if (seconds < 1) return `${Math.round(1000 * seconds)} ms`;
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}
