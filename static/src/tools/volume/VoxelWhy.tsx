import type { ComponentChild } from "preact";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { Panel } from "../../ui/Panel";
import { PlaceForm } from "../../ui/PlaceForm";
import type { SurfaceVoxelMessage, VoxelMessage } from "../../wire/protocol";

const millimetres = (metres: number): string => `${written(1000 * metres, 1)} mm`;

interface SurfaceWhyProps {
  readonly now: SurfaceVoxelMessage;
  readonly centre: readonly number[];
}

/** Why the chosen voxel of the surface has its distance: what each scan measured there. */
function SurfaceWhy({ now, centre }: SurfaceWhyProps) {
  const { distance, weight, size, total, updates, index } = now;
  return (
    <div data-surface-voxel data-total={total}>
      <p>
        The voxel at <span class="number">{centre.map((coordinate) => written(coordinate, 2)).join(", ")} m</span>,{" "}
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
      <Updates columns={["Scan", "Measured", "Mean", "Weight"]}>
        {updates.map((update) => (
          <tr key={update.scan}>
            <td class="number">{update.scan}</td>
            <td class="number">{millimetres(update.measured)}</td>
            <td class="number">
              {update.before === null ? "unknown" : millimetres(update.before)} → {millimetres(update.after)}
            </td>
            <td class="number">{written(update.weight, 2)}</td>
          </tr>
        ))}
      </Updates>
    </div>
  );
}

interface UpdatesProps {
  readonly columns: readonly string[];
  /** A row for each update, the oldest first. */
  readonly children: readonly ComponentChild[];
}

/** The effect of scans on a voxel, newest first; empty if there was none. */
function Updates({ columns, children }: UpdatesProps) {
  if (children.length === 0) return null;
  return (
    <div class="volume-updates">
      <table>
        <thead>
          <tr>
            {columns.map((column) => (
              <th key={column} scope="col">
                {column}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>{[...children].reverse()}</tbody>
      </table>
    </div>
  );
}

const probability = (logOdds: number): string => written(1 / (1 + Math.exp(-logOdds)), 2);
const coordinates = (place: readonly number[]): string => place.map((coordinate) => written(coordinate, 2)).join(", ");

/** Why the chosen voxel has its state: the effect of each scan on it. */
export function VoxelWhy({ store }: { readonly store: Store }) {
  const now = store.part("voxel").message.value;
  const ofSurface = store.part("surface_voxel").message.value;
  const isComputing = store.working.value?.what === "voxel";
  return (
    <Panel title="Why does this voxel have its value?">
      <p class="quiet">Click a voxel in the picture, or enter a place:</p>
      <PlaceForm label="Ask" onPlace={([x, y, z]) => store.send({ type: "voxel", x, y, z })} />
      <p aria-live="polite" class="quiet">
        {isComputing && "Going through the beams of all scans …"}
      </p>
      {(now?.centre || ofSurface?.centre) && (
        <div class="actions">
          <Button onClick={() => store.send({ type: "voxel" })}>Choose none</Button>
        </div>
      )}
      {ofSurface?.centre ? (
        <SurfaceWhy now={ofSurface} centre={ofSurface.centre} />
      ) : (
        now?.centre && (
          <Answer now={now} centre={now.centre} hasScans={store.part("volume").message.value?.has_scans ?? true} />
        )
      )}
    </Panel>
  );
}

interface AnswerProps {
  readonly now: VoxelMessage;
  readonly centre: readonly number[];
  readonly hasScans: boolean;
}

function Answer({ now, centre, hasScans }: AnswerProps) {
  const { log_odds, state, size, total, hits, updates, index, point } = now;
  return (
    <div data-voxel={state} data-hits={hits} data-total={total}>
      <p>
        The voxel at <span class="number">{coordinates(centre)} m</span>, <span class="number">{size} m</span> wide, is{" "}
        <strong>{state}</strong>
        {log_odds !== null && (
          <>
            : p = <span class="number">{probability(log_odds)}</span>, log-odds{" "}
            <span class="number">{written(log_odds, 2)}</span>
          </>
        )}
        .
      </p>
      {point && (
        <p data-points={point.count}>
          {point.count === 1 ? "One point is" : `${point.count.toLocaleString("en")} points are`} in it
          {point.count > 1 && "; the nearest to the click is"} at{" "}
          <span class="number">{coordinates(point.place)} m</span>, of scan <span class="number">{point.scan}</span>
          {Object.entries(point.values).map(([name, values]) => (
            <span key={name}>
              , {name === "rgb" ? "colour" : name}{" "}
              <span class="number">{values.map((value) => Number(value.toPrecision(6))).join(", ")}</span>
            </span>
          ))}
          .
        </p>
      )}
      {hasScans ? (
        <p>
          {total === 0
            ? `None of ${index} scans has updated it.`
            : `${total} of ${index} scans updated it: in ${hits} a beam ended in it, in ${total - hits} beams only passed it.`}
        </p>
      ) : (
        <p class="quiet">An octree does not contain the scans from which it was made.</p>
      )}
      <Updates columns={["Scan", "Beams", "Log-odds"]}>
        {updates.map((update) => (
          <tr key={update.scan} class={update.hit ? "hit" : "miss"}>
            <td class="number">{update.scan}</td>
            <td>
              {update.beams >= 64 ? "64 or more" : update.beams} {update.hit ? "ended in it" : "passed it"}
            </td>
            <td class="number">
              {update.before === null ? "unknown" : written(update.before, 2)} → {written(update.after, 2)}
            </td>
          </tr>
        ))}
      </Updates>
    </div>
  );
}
