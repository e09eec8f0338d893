import { useSignal, useSignalEffect } from "@preact/signals";
import type { Store } from "../../state";
import { Button } from "../../ui/Button";
import { Panel } from "../../ui/Panel";
import { type Examination, examine, type Finding, surety } from "./doctor";
import "./doctor.css";
import { witness } from "./words";

type State =
  | { readonly kind: "idle" }
  | { readonly kind: "busy" }
  | { readonly kind: "failed"; readonly why: string }
  | { readonly kind: "done"; readonly examination: Examination };

const CHECKED =
  "its clock, readings at max range, beams that see the robot, the sensor's mount, a delay between scans and poses, " +
  "drift, and things that move";

/** The log doctor: what is wrong with a log, where, how surely, and what to do about it. */
export function Doctor({ store, session }: { readonly store: Store; readonly session: string }) {
  const state = useSignal<State>({ kind: "idle" });
  useSignalEffect(() => {
    // Another trajectory is another patient.
    const now = store.trajectory.value?.name;
    const before = state.peek();
    if (before.kind === "done" && now !== undefined && now !== before.examination.trajectory) {
      state.value = { kind: "idle" };
    }
  });
  const look = async (): Promise<void> => {
    state.value = { kind: "busy" };
    try {
      state.value = { kind: "done", examination: await examine(session) };
    } catch (error) {
      const why = error instanceof TypeError ? "The server does not answer." : (error as Error).message;
      state.value = { kind: "failed", why };
    }
  };
  const now = state.value;
  return (
    <Panel title="Log doctor">
      {now.kind !== "done" && (
        <>
          <p class="quiet">Looks for what spoils a map: {CHECKED}.</p>
          <Button icon="target" disabled={now.kind === "busy"} onClick={() => void look()}>
            {now.kind === "busy" ? "Examining …" : "Examine this log"}
          </Button>
        </>
      )}
      <div role="status">
        {now.kind === "failed" && <p class="doctor-failed">{now.why}</p>}
        {now.kind === "done" && now.examination.findings.length === 0 && (
          <p>
            Nothing found. Poses: {witness(now.examination.trajectory)}. Looked at: {CHECKED}.
          </p>
        )}
        {now.kind === "done" && now.examination.findings.length > 0 && (
          <ul class="findings" aria-label="Findings">
            {now.examination.findings.map((finding) => (
              <Told key={finding.check} finding={finding} store={store} />
            ))}
          </ul>
        )}
      </div>
    </Panel>
  );
}

function Told({ finding, store }: { readonly finding: Finding; readonly store: Store }) {
  const { parameters, scans } = finding;
  const values = store.mapping.values.value;
  const tried = parameters !== null && Object.entries(parameters).every(([name, value]) => values[name] === value);
  return (
    <li class="finding" data-check={finding.check}>
      <p>
        <span class="finding-sure">{surety(finding.sure)}</span> {finding.sentence}
      </p>
      <p class="quiet">{finding.advice}</p>
      <div class="finding-actions">
        {parameters && (
          <Button disabled={tried} onClick={() => store.setTogether(`doctor ${finding.check}`, parameters)}>
            {tried ? "Tried on the map" : "Try it on the map"}
          </Button>
        )}
        {scans.slice(0, 6).map((scan) => (
          <Button
            key={scan}
            kind="quiet"
            label={`Go to scan ${scan + 1}`}
            onClick={() => store.send({ type: "seek", index: scan + 1 })}
          >
            scan {scan + 1}
          </Button>
        ))}
      </div>
    </li>
  );
}
