import { written } from "../../ui/numbers";
import type { SurfaceVoxelMessage } from "../../wire/protocol";

const millimetres = (metres: number): string => `${written(1000 * metres, 1)} mm`;

interface SurfaceWhyProps {
  readonly now: SurfaceVoxelMessage;
  readonly centre: readonly number[];
}

/** Why the chosen voxel of the surface has its distance: what each scan measured there. */
export function SurfaceWhy({ now, centre }: SurfaceWhyProps) {
  const { distance, weight, size, total, updates, index } = now;
  return (
    <div data-surface-voxel data-total={total}>
      <p>
        The voxel at <span class="number">{centre.map((one) => written(one, 2)).join(", ")} m</span>,{" "}
        <span class="number">{size} m</span> wide,{" "}
        {distance === null ? (
          "has no distance."
        ) : (
          <>
            is <span class="number">{millimetres(Math.abs(distance))}</span>{" "}
            <strong>{distance >= 0 ? "before" : "behind"}</strong> the surface: a mean of weight{" "}
            <span class="number">{written(weight, 2)}</span>.
          </>
        )}
      </p>
      <p>{total === 0 ? `None of ${index} scans measured it.` : `${total} of ${index} scans measured it.`}</p>
      {updates.length > 0 && (
        <div class="volume-updates">
          <table>
            <thead>
              <tr>
                <th scope="col">Scan</th>
                <th scope="col">Measured</th>
                <th scope="col">Mean</th>
                <th scope="col">Weight</th>
              </tr>
            </thead>
            <tbody>
              {[...updates].reverse().map((one) => (
                <tr key={one.scan}>
                  <td class="number">{one.scan}</td>
                  <td class="number">{millimetres(one.measured)}</td>
                  <td class="number">
                    {one.before === null ? "unknown" : millimetres(one.before)} → {millimetres(one.after)}
                  </td>
                  <td class="number">{written(one.weight, 2)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </div>
  );
}
