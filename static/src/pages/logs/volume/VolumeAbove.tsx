import type { Store } from "../../../store/store";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { BeliefView } from "../../../tools/picture/BeliefView";
import { useLook } from "../../../tools/volume/useLook";
import { Button } from "../../../ui/Button";
import { MapFiles } from "../../../ui/files/MapFiles";

const BAND = ["band_low", "band_high"];

/** The map from above, of a band of heights or a slice, and its files. */
export function VolumeAbove({ store, session }: { readonly store: Store; readonly session: string }) {
  const look = useLook(store);
  if (!look) return null;
  const { rows, values, set } = look;
  const low = Number(values.value.band_low);
  const high = Number(values.value.band_high);
  const [first, last] = BAND.map((name) => rows.find((row) => row.name === name));
  return (
    <div class="volume-above">
      <div class="volume-above-map">
        <BeliefView store={store} />
      </div>
      <ParameterRows rows={rows.filter(({ name }) => BAND.includes(name))} values={values} set={set} />
      <div class="actions">
        <Button
          onClick={() => {
            const middle = Math.round(50 * (low + high)) / 100;
            store.send({ type: "volume_look", values: { band_low: middle, band_high: middle } });
          }}
        >
          Slice in the middle
        </Button>
        <Button
          onClick={() =>
            store.send({
              type: "volume_look",
              values: { band_low: first?.initial ?? low, band_high: last?.initial ?? high },
            })
          }
        >
          All heights
        </Button>
        <MapFiles session={session} />
      </div>
    </div>
  );
}
