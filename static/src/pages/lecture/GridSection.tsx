import { signal } from "@preact/signals";
import { Independence } from "../../lessons/independence/Independence";
import type { Senses } from "../../lessons/independence/model";
import { Scrub } from "../../ui/Scrub";
import { Section } from "./Section";

const senses = signal<Senses>({ prior: 0.2, sonarError: 0.05, beamError: 0.1 });

const set = (name: keyof Senses) => (percent: number) => {
  senses.value = { ...senses.peek(), [name]: percent / 100 };
};

export function GridSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { prior, sonarError, beamError } = senses.value;
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Independence senses={senses} />}
      sources={[
        ["moravec-elfes", ""],
        ["elfes", ""],
        ["probabilistic-robotics", "sections 9.1, 9.2 and 9.4"],
      ]}
      after={
        <>
          <p>
            The joint knows that <em>something</em> made the echo. Each cell that a beam passes makes the remaining
            cells guiltier. The grid map has kept no memory of who was suspected together, so the cells that are left
            stay where the echo put them. Press the cells: leave one suspect, then none.
          </p>
          <p>
            That is the price. What it buys is a map that fits into memory: a joint over a grid of 100 × 100 cells would
            need 2<sup>10000</sup> numbers, the grid map needs 10 000. With a narrow laser beam little is lost, because
            few cells are ever suspected together.
          </p>
        </>
      }
    >
      <p>
        A robot wants to know where it can drive. An occupancy grid map cuts the floor into square cells and asks the
        same question of each: is something there? It makes three assumptions.
      </p>
      <ol>
        <li>
          A cell is either <b class="noun-hit">occupied</b> or <b class="noun-miss">free</b>, as a whole.
        </li>
        <li>The world stands still while it is mapped.</li>
        <li>Each cell is independent of all others, so a map’s probability is the product of its cells’.</li>
      </ol>
      <p>
        And one thing must be given: where the sensor was at each reading. The first two assumptions come back in later
        sections. Here is what the third gives up.
      </p>
      <p>
        A <b class="noun-beam">sonar</b> has heard an echo from somewhere on an arc of five cells; each was occupied
        with{" "}
        <Scrub
          label="prior of a cell"
          sentence="How probable it was, before any reading, that a cell is occupied."
          value={100 * prior}
          unit="%"
          tone="prior"
          low={5}
          high={50}
          step={1}
          onInput={set("prior")}
        />{" "}
        before. The sonar is wrong in{" "}
        <Scrub
          label="error of the sonar"
          sentence="How often the sonar hears an echo from an empty arc, or none from an occupied one."
          value={100 * sonarError}
          unit="%"
          tone="beam"
          low={1}
          high={30}
          step={1}
          onInput={set("sonarError")}
        />{" "}
        of its answers. Then a narrow beam, wrong in{" "}
        <Scrub
          label="error of the narrow beam"
          sentence="How often the narrow beam is wrong about a cell."
          value={100 * beamError}
          unit="%"
          tone="beam"
          low={1}
          high={40}
          step={1}
          onInput={set("beamError")}
          after=","
        />{" "}
        looked at cells 1, 2 and 4 and <b class="noun-miss">passed</b>. The same evidence, kept in two ways: a number
        for each cell, as this mapper does it, and a number for each of the 32 possible maps, which for a whole floor no
        mapper could afford.
      </p>
    </Section>
  );
}
