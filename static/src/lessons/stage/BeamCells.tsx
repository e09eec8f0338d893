/** One beam of the newest scan: its cells with the evidence that it gives them, its end point, its window. */

import { bearingOf, evidenceOfBeam } from "../../grid/textbook";
import { written } from "../../ui/numbers";
import { pipelineBeam, pipelineStep } from "./controls";
import { readingOf } from "./reading";
import type { MarkProps } from "./scene";

/** How far a reading has come: 1 its end point, 2 that cell, 3 the cells of its beam, 4 their evidence. */
const ALL = 4;

interface BeamProps extends MarkProps {
  readonly step: number;
}

export const BeamCells = (props: MarkProps) => <Beam {...props} step={ALL} />;
export const ReadingCells = (props: MarkProps) => <Beam {...props} step={pipelineStep.value} />;

/** The chosen beam of the newest scan. */
function Beam({ transform, scene, shown, step }: BeamProps) {
  const reading = readingOf(scene, shown, pipelineBeam.value);
  if (!reading) return null;
  const { pose, scan, beam, end, range } = reading;
  const { resolution } = shown.map.geometry;
  const cells = evidenceOfBeam(shown.map.geometry, scan, beam, pose, scene.config);
  const half = scene.config.window / 2;
  const angle = pose[2] + bearingOf(scan, beam);
  const at = (z: number): string =>
    `${transform.x(pose[0] + z * Math.cos(angle))} ${transform.y(pose[1] + z * Math.sin(angle))}`;
  return (
    <>
      {step >= 3 &&
        cells.map(({ cell, evidence }) => (
          <rect
            key={`${cell.row} ${cell.col}`}
            class={`world-stage-cell ${step < ALL ? "line" : evidence > 0 ? "hit" : "miss"}`}
            x={transform.x(cell.col * resolution)}
            y={transform.y((cell.row + 1) * resolution)}
            width={transform.cell}
            height={transform.cell}
          />
        ))}
      <path class="world-stage-beam" d={`M${at(0)}L${at(range)}`} />
      {half > 0 && <path class="world-stage-beam-window" d={`M${at(range - half)}L${at(range + half)}`} />}
      {step >= 1 && <circle class="world-stage-end" cx={transform.x(end[0])} cy={transform.y(end[1])} r={6} />}
      <text class="world-stage-label beam" x={transform.x(end[0]) + 10} y={transform.y(end[1]) - 10}>
        z = {written(range, 2)} m
      </text>
      {step === 2 && (
        <rect
          class="world-stage-selected"
          x={transform.x(reading.cell.col * resolution)}
          y={transform.y((reading.cell.row + 1) * resolution)}
          width={transform.cell}
          height={transform.cell}
        />
      )}
    </>
  );
}
