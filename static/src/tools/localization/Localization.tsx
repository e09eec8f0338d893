/** The robot localized in the plan of its world: begun, kidnapped, and what goes wrong. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { SwitchChip } from "../../ui/SwitchChip";
import type { LocalizationMessage, Values } from "../../wire/protocol";
import { AmclYaml } from "./AmclYaml";
import { ErrorChart } from "./ErrorChart";
import { grown, mapOf, PARTICLES, type Point, SETTINGS, turned, valuesOf } from "./model";
import "./localization.css";

const FIELD = "likelihood_field";

export function Localization({ store }: { readonly store: Store }) {
  const message = store.localization.value;
  const isOn = message?.is_on === true;
  const on = useSignal<readonly string[]>([]);
  const points = useSignal<readonly Point[]>([]);
  useSignalEffect(() => {
    const news = store.localization.value;
    points.value = news ? grown(points.peek(), news) : [];
  });
  useEffect(() => (isOn ? store.layers.subscribe(PARTICLES) : undefined), [store, isOn]);
  const showsField = store.underlay.value === FIELD;
  useEffect(() => {
    if (!isOn && store.underlay.peek() === FIELD) store.underlay.value = null;
    return isOn && showsField ? store.layers.subscribe(FIELD) : undefined;
  }, [store, isOn, showsField]);
  // Parameters of an AMCL's yaml; the settings come on top of them.
  const given = useSignal<Values>({});
  const allValues = (): Values => ({ ...given.peek(), ...valuesOf(on.peek()) });
  const begin = (names: readonly string[]): void => {
    on.value = names;
    points.value = [];
    store.send({ type: "localize", value: true, values: allValues(), map: mapOf(names) });
  };
  const turn = (name: string): void => {
    const world = SETTINGS.find((one) => one.name === name)?.world;
    const isTurnedOn = !on.peek().includes(name);
    if (isTurnedOn && world !== undefined && store.world.peek()?.name !== world) store.chooseWorld(world);
    begin(turned(on.peek(), name));
  };
  return (
    <div class="localization">
      <p class="localization-note">
        A particle filter gets the plan of the world as it is now, the wheels' odometry and the scans. It has to find
        out where the robot is.
      </p>
      <div class="localization-row">
        <Button kind="primary" onClick={() => begin(on.peek())}>
          {isOn ? "Start anew, anywhere" : "Find the robot"}
        </Button>
        {isOn && (
          <Button kind="quiet" onClick={() => store.send({ type: "localize", value: false })}>
            End
          </Button>
        )}
      </div>
      <fieldset class="localization-row">
        <legend>What goes wrong</legend>
        {SETTINGS.map(({ name, label, look }) => (
          <SwitchChip
            key={name}
            label={label}
            title={look}
            checked={on.value.includes(name)}
            onChange={() => turn(name)}
          />
        ))}
      </fieldset>
      {isOn && message && (
        <>
          <Outcome message={message} />
          <ErrorChart points={points.value} />
          <p class="localization-key">
            <span class="key error" aria-hidden="true" /> error <span class="key entropy" aria-hidden="true" /> entropy
          </p>
          <p class="localization-note">
            <b>Kidnap the robot:</b> click somewhere else in the world. The filter is not told.
          </p>
        </>
      )}
      {isOn && (
        <SwitchChip
          label="Likelihood field under the particles"
          checked={showsField}
          onChange={(wanted) => {
            store.underlay.value = wanted ? FIELD : null;
          }}
        />
      )}
      <AmclYaml
        values={allValues}
        onOpen={(values) => {
          given.value = values;
          begin(on.peek());
        }}
      />
      <div class="localization-note" role="status">
        {SETTINGS.filter(({ name }) => on.value.includes(name)).map(({ name, look }) => (
          <p key={name}>
            <b>Look for:</b> {look}
          </p>
        ))}
      </div>
    </div>
  );
}

function Outcome({ message }: { readonly message: LocalizationMessage }) {
  const off = message.error_m ?? 0;
  const isRight = message.is_converged && off < 1;
  const verdict = isRight ? "Found" : message.is_converged ? "Wrong, and sure of it" : "Not found yet";
  return (
    <dl class="localization-numbers">
      <div>
        <dt>State</dt>
        <dd>{verdict}</dd>
      </div>
      <div>
        <dt>Error</dt>
        <dd>{off.toFixed(2)} m</dd>
      </div>
      <div>
        <dt>Particles</dt>
        <dd>{message.n_particles.toLocaleString("en")}</dd>
      </div>
      <div>
        <dt>Entropy</dt>
        <dd>{message.entropy.toFixed(1)} bit</dd>
      </div>
    </dl>
  );
}
