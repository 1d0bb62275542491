# diagnosis
