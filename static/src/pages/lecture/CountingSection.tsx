import { signal } from "@preact/signals";
import { Counting } from "../../lessons/counting/Counting";
import { Scrub } from "../../ui/Scrub";
import { Section } from "./Section";

const beams = signal(180);
const scans = signal(1);

export function CountingSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Counting beams={beams} scans={scans} />}
      sources={[["probabilistic-robotics", "tables 9.1 and 9.2"]]}
      after={
        <>
          <p>
            Near the sensor all beams run through the same few cells. <b>Per beam</b>, each of them adds its evidence,
            and one scan makes those cells as sure as the clamp allows; the dashed curve is how many beams a cell’s
            width covers, beams × cell / 2π<i>s</i> at distance <i>s</i>. But a scan is one look from one pose: its
            beams share every error of that pose, and counting them apart counts the same thing many times.
          </p>
          <p>
            <b>Per scan</b>, as table 9.1 of <cite>Probabilistic Robotics</cite> has it, a cell in view is updated once,
            by the beam nearest in bearing. As printed it looks at every cell of the map for each scan; the mapper fills
            a scan’s field from its border, with the same result. It offers both, and per beam is the default.
          </p>
        </>
      }
    >
      <p>
        Log-odds may be added when readings are independent, given the cell. Are the{" "}
        <Scrub
          label="beams of a scan"
          sentence="How many beams the lidar sends all round in one scan."
          value={beams.value}
          text={`${beams.value} beams`}
          tone="beam"
          low={36}
          high={720}
          step={12}
          onInput={(value) => {
            beams.value = value;
          }}
        />{" "}
        of one scan? Here is a map after{" "}
        <Scrub
          label="scans"
          sentence="How many times the robot looks from the same place."
          value={scans.value}
          text={scans.value === 1 ? "1 scan" : `${scans.value} scans`}
          tone="beam"
          low={1}
          high={10}
          step={1}
          onInput={(value) => {
            scans.value = value;
          }}
          after=","
        />{" "}
        made in two ways. Drag the cross over the cells.
      </p>
    </Section>
  );
}
