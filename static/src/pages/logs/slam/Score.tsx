/** The score of the poses in use against known relations between places, beside published results. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { written } from "../../../ui/numbers";
import { Panel } from "../../../ui/Panel";
import { trajectoryLabel } from "../library/describeLog";
import { type PoseScore, scorePoses } from "./api";

interface Row {
  readonly name: string;
  readonly translation: number;
  readonly rotation: number | null;
  readonly count: number | null;
  readonly source: string | null;
}

/** One's own rows, and those of others, the best first. */
export function rowsOf(score: PoseScore): readonly Row[] {
  const own = [
    { name: trajectoryLabel(score.trajectory), figures: score.all },
    { name: `${trajectoryLabel(score.trajectory)}, unambiguous`, figures: score.unambiguous },
  ].flatMap(({ name, figures }) =>
    figures
      ? [
          {
            name,
            translation: figures.translation_m,
            rotation: figures.rotation_deg,
            count: figures.count,
            source: null,
          },
        ]
      : [],
  );
  const others = score.published.map(({ program, translation, rotation, count, source }) => ({
    name: program,
    translation,
    rotation,
    count,
    source,
  }));
  return [...own, ...others].sort((a, b) => a.translation - b.translation);
}

export function Score({ store, session }: { readonly store: Store; readonly session: string }) {
  const input = useRef<HTMLInputElement>(null);
  const file = useSignal<File | null>(null);
  const score = useSignal<PoseScore | null>(null);
  const failure = useSignal<string | null>(null);
  const isBusy = useSignal(false);
  const trajectory = store.trajectory.value?.name ?? null;
  const chosen = file.value;
  useEffect(() => {
    if (!chosen || trajectory === null) return;
    let isCurrent = true;
    isBusy.value = true;
    failure.value = null;
    scorePoses(session, chosen)
      .then((found) => {
        if (isCurrent) score.value = found;
      })
      .catch((error: unknown) => {
        if (!isCurrent) return;
        score.value = null;
        failure.value = (error as Error).message;
      })
      .finally(() => {
        if (isCurrent) isBusy.value = false;
      });
    return () => {
      isCurrent = false;
    };
  }, [chosen, trajectory, session, isBusy, failure, score]);
  return (
    <Panel title="Score its poses">
      <div class="panel-stack">
        <p class="quiet">
          A file of relations states measured motions between places of a log (Kümmerle and others 2009). The score is
          how far the poses are from them on average.
        </p>
        <input
          ref={input}
          type="file"
          hidden
          aria-label="File of relations"
          onChange={(event) => {
            file.value = event.currentTarget.files?.[0] ?? null;
            event.currentTarget.value = "";
          }}
        />
        <div class="actions">
          <Button icon="upload" disabled={isBusy.value} onClick={() => input.current?.click()}>
            {chosen ? "Another file of relations" : "Choose a file of relations"}
          </Button>
        </div>
        {isBusy.value && <p role="status">Scoring {trajectoryLabel(trajectory ?? "")} …</p>}
        {failure.value !== null && (
          <p class="failure" role="alert">
            {failure.value}
          </p>
        )}
        {score.value && !isBusy.value && <Table score={score.value} />}
      </div>
    </Panel>
  );
}

/** Author and year, or who measured it: what comes before the title or the log. */
const shortSource = (source: string): string => source.split(/[,:]/, 1)[0] ?? source;

function Table({ score }: { readonly score: PoseScore }) {
  const rows = rowsOf(score);
  const sources = [...new Set(rows.flatMap(({ source }) => (source === null ? [] : [source])))];
  return (
    <>
      <table class="score-table">
        <caption>Mean errors of position, metres, and of rotation, degrees</caption>
        <thead>
          <tr>
            <th scope="col">Poses</th>
            <th scope="col">m</th>
            <th scope="col">°</th>
            <th scope="col">relations</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(({ name, translation, rotation, count, source }) => (
            <tr key={name} class={source === null ? "score-own" : ""}>
              <th scope="row">
                {name}
                {source !== null && <small>{shortSource(source)}</small>}
              </th>
              <td>{written(translation, 4)}</td>
              <td>{rotation === null ? "–" : written(rotation, 2)}</td>
              <td>{count?.toLocaleString("en") ?? "–"}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="quiet">
        {score.policy === "records"
          ? "Stamps of the relations are mapped to the log’s odometry messages in the order of its records; a relation is unambiguous if each of its stamps has one message."
          : "Poses are interpolated in time between the scans."}
        {score.left_out > 0 &&
          ` ${score.left_out} of ${score.relations} relations are left out: the log has no record of their times.`}
        {score.published.length === 0 && " The name of the file is not that of a log with published results."}
      </p>
      {sources.length > 0 && (
        <ul class="score-sources quiet">
          {sources.map((source) => (
            <li key={source}>{source}</li>
          ))}
        </ul>
      )}
    </>
  );
}
