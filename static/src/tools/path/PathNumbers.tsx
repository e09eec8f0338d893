import { written } from "../../ui/numbers";
import type { PathMessage } from "../../wire/protocol";

interface PathNumbersProps {
  /** The path; null before there is a goal. */
  readonly path: PathMessage | null;
}

/** Numbers of a path. Before there is a goal they are dashes, which show what a goal will tell. */
export function PathNumbers({ path }: PathNumbersProps) {
  const number = (value: number | null | undefined, digits: number, unit: string): string =>
    value === null || value === undefined ? `– ${unit}` : `${written(value, digits)} ${unit}`;
  const rows: [label: string, text: string][] = [["Path", number(path?.length, 1, "m")]];
  if (!path || path.travel_s !== null) rows.push(["Travel time", number(path?.travel_s, 1, "s")]);
  rows.push(["Cost", path ? Math.round(path.cost ?? 0).toLocaleString("en") : "–"]);
  rows.push(["Planned in", number(path?.plan_ms, 1, "ms")]);
  if (path && path.speed_limit !== null) rows.push(["Speed limit", path.speed_limit]);
  return (
    <dl class={`number-row${path ? "" : " awaited"}`}>
      {rows.map(([label, text]) => (
        <div key={label}>
          <dt>{label}</dt>
          <dd>{text}</dd>
        </div>
      ))}
    </dl>
  );
}
