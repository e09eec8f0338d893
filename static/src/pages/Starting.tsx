import { Working } from "../ui/Working";
import { starting } from "./worldSession";

/** Longer than a start takes once the server has compiled its functions. */
const COMPILING_AFTER_S = 2;

/** A note while the server makes a new world, in a corner of the page or over what contains it. */
export function Starting({ isInside = false }: { readonly isInside?: boolean }) {
  const work = starting.value;
  const isCompiling = work !== null && work.elapsed_s > COMPILING_AFTER_S;
  const making = isCompiling ? "The first start on a server compiles the mapping functions" : "Starting the simulation";
  return (
    <Working
      what={work?.isAnswered === false ? "The server does not answer yet" : making}
      work={work}
      isInside={isInside}
    />
  );
}
