import { useRef } from "preact/hooks";
import { toLattice } from "../../grid/lattice";
import { bound } from "../../ui/bound";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { useInSight } from "../common/useSteps";
import { cellSide, originAt, pipelineBeam } from "../stage/controls";
import { readingOf } from "../stage/reading";
import { nowOf } from "../stage/scene";
import { SCENES } from "../stage/scenes";
import "./endpoint.css";

const DEGREE = Math.PI / 180;

/** The way from a reading to its cell in numbers, and the controls that the stage has no handle for. */
export function Endpoint() {
  const root = useRef<HTMLDivElement>(null);
  const scene = useInSight(root, SCENES.endpoint);
  const reading = readingOf(scene, nowOf(scene), pipelineBeam.value);
  const side = cellSide.value;
  const [ox, oy] = originAt.value;
  return (
    <div class="endpoint" ref={root}>
      {reading ? (
        <dl class="endpoint-steps number" aria-live="polite">
          <dt>end point x</dt>
          <dd>
            <span class="noun-robot">{written(reading.pose[0], 2)}</span> +{" "}
            <span class="noun-beam">{written(reading.range, 2)}</span> cos(
            <span class="noun-robot">{written(reading.pose[2] / DEGREE, 0)}°</span> +{" "}
            <span class="noun-beam">{written(reading.bearing / DEGREE, 0)}°</span>) ={" "}
            <b>{written(reading.end[0], 2)} m</b>
          </dd>
          <dt>end point y</dt>
          <dd>
            <span class="noun-robot">{written(reading.pose[1], 2)}</span> +{" "}
            <span class="noun-beam">{written(reading.range, 2)}</span> sin(
            <span class="noun-robot">{written(reading.pose[2] / DEGREE, 0)}°</span> +{" "}
            <span class="noun-beam">{written(reading.bearing / DEGREE, 0)}°</span>) ={" "}
            <b>{written(reading.end[1], 2)} m</b>
          </dd>
          <Index name="column" value={reading.end[0]} origin={ox} side={side} />
          <Index name="row" value={reading.end[1]} origin={oy} side={side} />
        </dl>
      ) : (
        <p aria-live="polite">This beam has no return: there is no end point. Select another beam.</p>
      )}
      <div class="figure-controls no-print">
        <Slider
          label="Resolution: side of a cell"
          sentence="How long the side of a cell is; the grid on the stage has these cells."
          value={side}
          initial={0.5}
          low={0.1}
          high={1}
          step={0.1}
          unit="m"
          onInput={(value) => {
            cellSide.value = value;
          }}
        />
        <Slider
          label="Beam k"
          sentence="Number of the beam in the scan, counter-clockwise from straight ahead."
          {...bound(pipelineBeam)}
          initial={36}
          low={0}
          high={239}
          step={1}
          tone="beam"
        />
      </div>
    </div>
  );
}

interface IndexProps {
  readonly name: string;
  readonly value: number;
  readonly origin: number;
  readonly side: number;
}

/** One coordinate of the cell: the quotient, rounded down. */
function Index({ name, value, origin, side }: IndexProps) {
  const [quotient] = toLattice({ origin: [origin, 0, 0], resolution: side }, value, 0);
  const floor = Math.floor(quotient);
  return (
    <>
      <dt>{name}</dt>
      <dd>
        floor(({written(value, 3)} − {written(origin, 2)}) / {written(side, 1)}) = floor({written(quotient, 2)}) ={" "}
        <b>{floor}</b>
        {floor < 0 && <span class="noun-hit"> (an integer conversion would give {Math.trunc(quotient) + 0})</span>}
      </dd>
    </>
  );
}
