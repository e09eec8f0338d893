import { Program } from "../../lessons/program/Program";
import { Section, type SectionHead } from "./Section";

export function AlgorithmSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Program />}
      sources={[
        ["probabilistic-robotics", "table 9.1 (the loop) and chapter 4 (the filter)"],
        ["bresenham", ""],
      ]}
      after={
        <p>
          When you drag a slider in the lab, compiled code performs the same steps instead. Tests compare the results of
          the two cell by cell, to the last bit. Tests also compare the lines that are highlighted here with a trace of
          the lines that Python executes.
        </p>
      }
    >
      <p>
        The same algorithm with its loops exchanged: for each beam, over the cells that it crosses. It combines the
        previous sections: which cells a beam crosses, what evidence it gives for each of them, and how a cell adds up
        the evidence. The program below is part of the mapper’s reference implementation in plain Python: five functions
        without their docstrings, copied from the source file when this page was built. The current line is highlighted.
        Step by line, by cell, by <b class="noun-beam">beam</b> or by scan, forwards or backwards. Drag the{" "}
        <b class="noun-robot">robot</b>, and the program runs on the readings from its new position.
      </p>
    </Section>
  );
}
