import { useSignal } from "@preact/signals";
import { distancesOf, occupancyOf, RESOLUTION, readingsOf, zeroCrossing } from "../../../lessons/tsdf/model";
import { Profiles } from "../../../lessons/tsdf/Profiles";
import "../../../lessons/tsdf/tsdf.css";

/** Where the wall of the figure is, and its readings; a voxel of the figure is 0.1 m. */
const FIRST = { wall: 1.23, readings: 20, sigma: 0.02 };

interface SurfaceProfileProps {
  /** Side of a voxel of the surface, m. */
  readonly resolution: number;
  /** Truncation of the surface, m. */
  readonly truncation: number;
  readonly maxWeight: number;
  readonly isCarved: boolean;
  readonly onTruncation: (metres: number) => void;
}

/** One beam at the voxels of this surface, in both maps; the truncation is dragged. */
export function SurfaceProfile({ resolution, truncation, maxWeight, isCarved, onTruncation }: SurfaceProfileProps) {
  const wall = useSignal(FIRST.wall);
  const scale = resolution / RESOLUTION;
  const readings = readingsOf(wall.value, FIRST.readings, FIRST.sigma, false);
  const voxels = distancesOf(readings, { truncation: truncation / scale, maxWeight, isCarved });
  return (
    <figure class="tsdf" aria-label="One beam as occupancy and as signed distance">
      <Profiles
        wall={wall.value}
        isMoved={false}
        readings={readings}
        occupancy={occupancyOf(readings)}
        voxels={voxels}
        crossing={zeroCrossing(voxels)}
        truncation={truncation / scale}
        maxWeight={maxWeight}
        scale={scale}
        onWall={(metres) => {
          wall.value = metres;
        }}
        onTruncation={(metres) => onTruncation(Math.round(1000 * metres * scale) / 1000)}
      />
    </figure>
  );
}
