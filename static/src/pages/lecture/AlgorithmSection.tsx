import { Program } from "../../lessons/program/Program";
import { Section } from "./Section";

export function AlgorithmSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Program />}
      sources={[
        ["probabilistic-robotics", "table 9.1 (the loop) and table 4.2 (the filter)"],
        ["bresenham", ""],
      ]}
      after={
        <p>
          This is not what runs when you drag a slider in the lab: there the same steps are compiled. The two are tested
          against each other, cell by cell, to the last bit; and that the lines which light up here are the lines which
          Python runs is tested against Python’s own trace.
        </p>
      }
    >
      <p>
        Now everything is there: which cells a beam crosses, what it says of each, how a cell adds that up. The program
        below is the mapper’s own textbook, five functions of it without their docstrings, taken from its file when this
        page was built. Each line that runs is lit. Go on by a line, a cell, a <b class="noun-beam">beam</b> or the
        whole scan, forwards and back; drag the <b class="noun-robot">robot</b> and it runs on other readings.
      </p>
    </Section>
  );
}
