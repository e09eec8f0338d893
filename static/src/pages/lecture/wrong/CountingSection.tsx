import { signal } from "@preact/signals";
import { Counting } from "../../../lessons/counting/Counting";
import { countingBeams, countingUpdate } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { Choice } from "../../../ui/Choice";
import { DragNumber } from "../../../ui/DragNumber";
import { Section, type SectionHead } from "../Section";

const scans = signal(1);

const UPDATES = [
  { value: "per_beam", label: "per beam" },
  { value: "per_scan", label: "per scan" },
];

export function CountingSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <>
          <Counting beams={countingBeams} scans={scans} />
          <div class="for-stage no-print">
            <Choice
              label="On the stage: updates"
              options={UPDATES}
              value={countingUpdate.value}
              onChange={(value) => {
                countingUpdate.value = value === "per_scan" ? "per_scan" : "per_beam";
              }}
            />
          </div>
        </>
      }
      sources={[["probabilistic-robotics", "tables 9.1 and 9.2"]]}
      after={
        <>
          <p>
            <b>Per beam</b>, each beam adds its evidence. Near the sensor all beams pass the same few cells, and a
            single scan makes those as certain as the clamp allows. The dashed curve is the number of beams in a cell at
            distance <i>r</i>: beams × cell size / (2π<i>r</i>). But all beams of a scan share the error of its pose,
            and adding them counts one error many times.
          </p>
          <p>
            <b>Per scan</b>, as in table 9.1, a cell in the perceptual field is updated once, by the beam nearest in
            bearing.
          </p>
        </>
      }
    >
      <p>
        Log-odds may be added if the readings are independent given the cell. Are the{" "}
        <DragNumber
          label="beams of a scan"
          sentence="Number of beams in one scan, evenly spaced over 360°."
          {...bound(countingBeams)}
          text={`${countingBeams.value} beams`}
          tone="beam"
          low={36}
          high={720}
          step={12}
        />{" "}
        of one scan independent? The figure shows the map after{" "}
        <DragNumber
          label="scans"
          sentence="Number of scans, all from the same pose."
          {...bound(scans)}
          text={scans.value === 1 ? "1 scan" : `${scans.value} scans`}
          tone="beam"
          low={1}
          high={10}
          step={1}
          after=","
        />{" "}
        updated in two ways. <span class="no-print">Drag the cross over the cells.</span>
      </p>
    </Section>
  );
}
