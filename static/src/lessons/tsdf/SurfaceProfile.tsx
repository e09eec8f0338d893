import { useSignal } from "@preact/signals";
import type { Value, Values } from "../../wire/protocol";
import { distancesOf, occupancyOf, RESOLUTION, readingsOf, zeroCrossing } from "./model";
import { Profiles } from "./Profiles";
import "./tsdf.css";

/** Where the wall of the figure is, and its readings; a voxel of the figure is 0.1 m. */
const FIRST = { wall: 1.23, readings: 20, sigma: 0.02 };

interface SurfaceProfileProps {
  /** Side of a voxel of the surface, m. */
  readonly resolution: number;
  /** Parameters of the surface, as `mapper/volume/surface/parameters.py` has them. */
  readonly values: Values;
  readonly set: (name: string, value: Value) => void;
}

/** One beam at the voxels of a surface, in both maps; truncation and maximum weight are dragged. */
export function SurfaceProfile({ resolution, values, set }: SurfaceProfileProps) {
  const wall = useSignal(FIRST.wall);
  const scale = resolution / RESOLUTION;
  const readings = readingsOf(wall.value, FIRST.readings, FIRST.sigma, false);
  const maxWeight = Number(values.max_weight);
  const fusion = {
    truncation: (Number(values.truncation) || 4 * resolution) / scale,
    maxWeight,
    isCarved: values.carve === true,
    hasDropOff: values.drop_off === true,
  };
  const voxels = distancesOf(readings, fusion);
  return (
    <figure class="tsdf stack-narrow" aria-label="One beam as occupancy and as signed distance">
      <Profiles
        wall={wall.value}
        isMoved={false}
        readings={readings}
        occupancy={occupancyOf(readings)}
        voxels={voxels}
        crossing={zeroCrossing(voxels)}
        truncation={fusion.truncation}
        maxWeight={maxWeight}
        scale={scale}
        onWall={(metres) => {
          wall.value = metres;
        }}
        onTruncation={(metres) => set("truncation", Math.round(1000 * metres * scale) / 1000)}
        onMaxWeight={(weight) => set("max_weight", weight)}
      />
    </figure>
  );
}
