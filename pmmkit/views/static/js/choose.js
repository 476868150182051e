// What a person chose of a column, sent with all that was chosen before.

export function choose(draw, choice) {
  const own = draw.app.intake;
  own.choices = [...own.choices.filter((x) => x.file !== choice.file || x.column !== choice.column), choice];
  return draw.look({ choice });
}
