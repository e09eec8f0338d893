import { SurfaceProfile } from "../../../lessons/tsdf/SurfaceProfile";
import type { Store } from "../../../store/store";
import { ParameterRows } from "../../../tools/parameters/ParameterRows";
import { lookOf } from "../../../tools/volume/useLook";
import { Button } from "../../../ui/Button";
import { bytes } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import type { Value } from "../../../wire/protocol";

/** The surface by truncated signed distances: its parameters, and what one beam does with them. */
export function SurfaceGroup({ store }: { readonly store: Store }) {
  const now = store.part("surface").message.value;
  if (!now) return null;
  if (now.table.length === 0) {
    return (
      <p class="quiet">
        A surface is made of distances along beams. The file does not say where its sensor was, so there are none.
      </p>
    );
  }
  const values = store.part("surface").values.values;
  const set = (name: string, value: Value): void => {
    store.part("surface").values.set(name, value);
    store.sendSoon({ type: "surface", values: { [name]: value } });
  };
  const isShown = lookOf(store).values.value.show === "surface";
  const resolution = Number(values.value.resolution);
  return (
    <>
      {!isShown && (
        <div class="actions">
          <Button
            kind="primary"
            onClick={() => {
              lookOf(store).set("show", "surface");
              store.send({ type: "volume_look", values: { show: "surface" } });
            }}
          >
            Show the surface
          </Button>
        </div>
      )}
      <Panel title="One beam, two maps">
        <p class="quiet">
          20 readings of a wall at {resolution} m voxels. Drag the truncation or the maximum weight: this surface is
          made again with it.
        </p>
        <SurfaceProfile resolution={resolution} values={values.value} set={set} />
      </Panel>
      <Panel title="Signed distances">
        <ParameterRows rows={now.table} values={values} set={set} />
      </Panel>
      {isShown && (
        <p class="quiet">
          {now.blocks.toLocaleString("en")} blocks of 8 × 8 × 8 voxels, {bytes(now.bytes)}.
          {now.snapshots.length > 0 && ` Kept to go back to: after scan ${now.snapshots.join(", ")}.`}
        </p>
      )}
    </>
  );
}
